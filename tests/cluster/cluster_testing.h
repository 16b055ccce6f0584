// Engines of several processes as one cluster, over TLS on the loopback.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "actors/cluster/seat.h"
#include "actors/engine/engine.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/cluster/certs/certificates.h"
#include "src/geometry/reference/clouds.h"
#include "src/input/generate/generate.h"
#include "src/input/npy/array_source.h"

namespace tessera {

inline constexpr std::uint64_t memory = std::uint64_t{256} << 20;

inline std::uint16_t free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  EXPECT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), length), 0);
  EXPECT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length), 0);
  ::close(socket);
  return ntohs(address.sin_port);
}

class ClusterTest : public ::testing::Test {
 protected:
  ClusterTest() {
    // Older than all certificates of nodes, those that have ended too.
    EXPECT_TRUE(make_authority(
        certs_, {.days = std::nullopt, .now = std::chrono::system_clock::now() - std::chrono::hours(96)}));
    EXPECT_TRUE(make_node(certs_, "all"));
  }

  ClusterOptions options(const std::string& name) {
    ClusterOptions options;
    options.node_name = name;
    options.listen = {"127.0.0.1", free_port()};
    options.coordinator = false;
    options.join = {first_};
    options.authority = authority_file(certs_);
    options.certificate = node_certificate_file(certs_, "all");
    options.key = node_key_file(certs_, "all");
    options.scratch = folder_.path() / ("scratch-" + name);
    std::filesystem::create_directories(options.scratch);
    options.log = [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      said_.insert(line);
      heard_.notify_all();
    };
    return options;
  }

  std::unique_ptr<Engine> coordinator(bool also_node = true) {
    auto first = options("first");
    first.coordinator = true;
    first.node = also_node;
    first_ = first.listen;
    first.join.clear();
    return start(std::move(first));
  }

  static std::unique_ptr<Engine> start(ClusterOptions options) {
    auto engine = Engine::join(1, memory, std::make_unique<Seat>(std::move(options)));
    EXPECT_TRUE(engine) << engine.error().where;
    return std::move(engine).value();
  }

  // Until somebody has logged a line with all of this in it.
  void wait_for(const std::string& a, const std::string& b) {
    std::unique_lock lock(mutex_);
    heard_.wait(lock, [&] {
      for (const std::string& line : said_) {
        if (line.find(a) != std::string::npos && line.find(b) != std::string::npos) return true;
      }
      return false;
    });
  }

  RoutedCloud routed(const std::string& name, std::size_t points = 20'000) {
    const auto coordinates = coordinates_of(make_cloud("uniform", 3, points, 1), 3);
    const auto out = folder_.path() / name;
    std::filesystem::create_directory(out);
    Progress progress;
    const Cloud cloud = Cloud::open_source(array_source("cloud", coordinates, 3), {.dimension = 3}).value();
    return route(cloud, run_folder(out), {.tiles = 12}, progress, {}).value();
  }

  // A file that all see, of more points than one stretch has.
  std::string file() {
    const auto path = folder_.path() / "cloud.npy";
    EXPECT_TRUE(generate({.points = 600'000}, path));
    return path.string();
  }
  Result<RoutedCloud> routed_by(const Engine& engine, const std::string& file, const std::string& name,
                                Progress& progress, const std::stop_token& stop = {},
                                const CloudOptions& options = {}) {
    const auto out = folder_.path() / name;
    std::filesystem::create_directory(out);
    BOOST_OUTCOME_TRY(cloud, Cloud::open({file}, options));
    const auto router = engine.router(memory);
    return route(cloud, run_folder(out), {.tiles = 12}, progress, stop, router.get());
  }

  // But for who has routed what.
  static void expect_same(const RoutedCloud& a, const RoutedCloud& b) {
    EXPECT_EQ(a.tile_bounds, b.tile_bounds);
    EXPECT_EQ(a.seeds, b.seeds);
    EXPECT_EQ(a.counts.read, b.counts.read);
    for (std::uint32_t t = 0; t < a.partition.tiles(); ++t) {
      const auto in_a = load_tile(a, TileId{t}), in_b = load_tile(b, TileId{t});
      ASSERT_TRUE(in_a && in_b) << (in_a ? in_b : in_a).error().where;
      EXPECT_EQ(in_a.value().points, in_b.value().points);
      EXPECT_EQ(in_a.value().ids, in_b.value().ids);
    }
  }

  static std::vector<std::uint64_t> run(Engine& engine, const RoutedCloud& run) {
    Progress progress;
    const auto summary =
        engine.run(run, run.folder.parent_path(), {.threads = 2, .memory_bytes = memory}, progress, {});
    EXPECT_TRUE(summary) << summary.error().where;
    std::vector<std::uint64_t> sums;
    if (!summary) return sums;
    for (const TileEntry& tile : summary.value().tiles) sums.push_back(tile.xxh3);
    return sums;
  }

  std::vector<std::uint64_t> alone() {
    Engine engine(2, memory);
    return run(engine, routed("alone"));
  }

  TemporaryFolder folder_ = TemporaryFolder::make().value();
  const std::filesystem::path certs_ = folder_.path() / "certs";
  HostPort first_;
  std::mutex mutex_;
  std::condition_variable heard_;
  std::set<std::string> said_;
};

}  // namespace tessera
