// The HTTP server: listeners, threads, connections. Boost.Asio stays behind it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/service/http/node_health.h"
#include "src/service/service.h"

namespace tessera::http {

struct ListenOptions {
  std::string address = "127.0.0.1";  // IPv4 or IPv6
  std::uint16_t port = 0;             // 0: a free one
  bool operations = false;            // health and figures, without a token, instead of the API
};

struct ServerOptions {
  std::vector<ListenOptions> listeners;
  std::filesystem::path certificate, key;  // PEM; empty: no TLS. Of the API's listeners.
  std::filesystem::path tokens;            // made when missing (src/service/http/tokens.h)
  std::filesystem::path sessions;    // of browsers, kept over a restart (src/service/http/sessions.h); empty: not kept
  std::vector<std::string> hosts;    // allowed in Host beside those of the loopback
  std::string public_url;            // "https://name/prefix": links are absolute, below it
  bool insecure = false;             // the API beyond the loopback without TLS
  std::uint32_t threads = 2;         // that serve connections, and never wait for a disk but to send its files
  std::uint32_t workers = 4;         // that do what waits for one; as many such requests are answered at once
  std::uint32_t changes = 4;         // requests that read inputs or change something that are answered at once,
  std::uint32_t questions = 2;       // and questions to results: beyond it one of each other caller (turns.h)
  std::uint32_t connections = 4096;  // at once, of each listener of the API, half of them from one address; more
                                     // are refused with 503
  std::uint32_t health_connections = 64;  // the same of listeners for operations
  std::chrono::milliseconds header_time{10'000}, idle_time{60'000}, body_time{30'000}, write_time{30'000},
      comment_time{15'000};
};

class Server {
 public:
  // Listens when it returns. Errors: usage for options that do not fit (and for the API beyond the loopback without
  // TLS, unless `insecure`), io for an address that cannot be taken. `backend` outlives it.
  static Result<std::unique_ptr<Server>> start(ServerOptions options, Backend& backend);
  // Health and figures of a process without an API: all its listeners are for operations. Errors as above.
  static Result<std::unique_ptr<Server>> start(ServerOptions options, const NodeHealth& node);
  // Connections end at once.
  ~Server();

  // Of the listeners, in order.
  std::vector<std::uint16_t> ports() const;
  // A token of an admin, for the address that is printed.
  std::string token() const;
  // Reads the file of tokens again, which may hold none by now, then certificate and key, for connections to come. What
  // has an error stays as it is.
  Status reload();
  // Takes no more connections, ends idle ones and streams, lets requests be answered for at most `time`. True when none
  // was left.
  bool drain(std::chrono::milliseconds time);

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  Status listen();
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::http
