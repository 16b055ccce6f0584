// A server that ends while connections come.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "src/service/http/server.h"

namespace tessera::service::http {
namespace {

class Node final : public NodeHealth {
 public:
  NodeFigures figures() const override { return {}; }
  std::optional<std::string> unready() const override { return std::nullopt; }
};

// Whether somebody has taken the connection, which ends at once.
bool reached(std::uint16_t port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool connected = ::connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  ::close(fd);
  return connected;
}

// One thread waits for the next connection when another closes what they come to: it was looked at half closed, in one
// of some hundred ends.
TEST(ServerEnd, TakesNoConnectionWhileItCloses) {
  const Node node;
  std::uint64_t connections = 0;
  for (int round = 0; round < 400; ++round) {
    ServerOptions options;
    options.listeners = {{.operations = true}};
    options.threads = 4;
    auto server = Server::start(options, node);
    ASSERT_TRUE(server) << server.error().where;
    const std::uint16_t port = server.value()->ports().at(0);
    std::atomic<std::uint64_t> taken{0};
    std::vector<std::jthread> callers;
    for (int i = 0; i < 2; ++i)
      callers.emplace_back([&] {
        while (reached(port)) ++taken;
      });
    while (taken < 4) std::this_thread::yield();
    server.value()->drain(std::chrono::seconds(10));
    callers.clear();
    connections += taken;
  }
  EXPECT_GE(connections, 1600u);
}

}  // namespace
}  // namespace tessera::service::http
