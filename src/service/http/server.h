// The HTTP server: listeners, threads and connections. Hides Boost.Asio.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/service/backend.h"
#include "src/service/http/node_health.h"

namespace tessera::service::http {

struct ListenOptions {
  std::string address = "127.0.0.1";  // IPv4 or IPv6
  std::uint16_t port = 0;             // 0: a free port
  bool operations = false;            // health and figures, without a token, instead of the API
};

struct ServerOptions {
  std::vector<ListenOptions> listeners;
  std::filesystem::path certificate, key;  // PEM, for the API's listeners; empty: no TLS
  std::filesystem::path tokens;            // made when missing (src/service/http/tokens.h)
  std::filesystem::path sessions;    // of browsers, kept over a restart (src/service/http/sessions.h); empty: not kept
  std::vector<std::string> hosts;    // that Host may have, in addition to those of the loopback
  std::string public_url;            // "https://name/prefix": links are absolute, below it
  bool insecure = false;             // allow the API beyond the loopback without TLS
  std::uint32_t threads = 2;         // that serve connections, and never wait for a disk except to send its files
  std::uint32_t workers = 4;         // for requests that wait for a disk; as many are answered at once
  std::uint32_t changes = 4;         // requests answered at once that read inputs or change something,
  std::uint32_t questions = 2;       // and questions to results; beyond it one of each other caller (turns.h)
  std::uint32_t connections = 4096;  // at once, for each listener of the API, half of them from one address; more are
                                     // refused with 503
  std::uint32_t health_connections = 64;  // the same for listeners for operations
  std::chrono::milliseconds header_time{10'000}, idle_time{60'000}, body_time{30'000}, write_time{30'000},
      comment_time{15'000};
};

class Server {
 public:
  // Returns after the server has begun to listen. Errors: usage for invalid options (and for the API beyond the
  // loopback without TLS, unless `insecure`); io for an address that is not available. `backend` must outlive the
  // server.
  static Result<std::unique_ptr<Server>> start(ServerOptions options, const Backend& backend);
  // Serves health and figures of a process without an API: all listeners are for operations. Errors as above.
  static Result<std::unique_ptr<Server>> start(ServerOptions options, const NodeHealth& node);
  // Ends all connections at once.
  ~Server();

  // Ports of the listeners, in order.
  std::vector<std::uint16_t> ports() const;
  // A token of an admin, for the address that is printed.
  std::string token() const;
  // Reads the tokens again, which may be none by now, then certificate and key, for new connections. What has an error
  // is not replaced.
  Status reload();
  // Accepts no more connections, ends idle ones and streams, and lets requests be answered for at most `time`. Returns
  // true when no connection was left.
  bool drain(std::chrono::milliseconds time);

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  Status listen();
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::service::http
