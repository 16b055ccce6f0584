// HTTP/1.1 to one server, over TCP or TLS: one request at a time, on a connection that is kept open.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "src/base/result.h"
#include "src/service/client/address.h"

namespace tessera::client {

struct HttpRequest {
  std::string method = "GET";
  std::string target;  // path and query, as they are sent
  std::map<std::string, std::string> headers = {};
  std::string body = {};
  // Instead of `body`: a source of `source_bytes` bytes. Each call fills the beginning of its argument with at least 1
  // byte, and returns the number of bytes. Not repeatable.
  std::uint64_t source_bytes = 0;
  std::function<Result<std::size_t>(std::span<char>)> source = {};
  // Whether the request may be sent again, when the server has just closed the kept connection.
  bool repeatable = true;
  std::chrono::seconds silence{60};  // the longest time without any byte
};

struct HttpHead {
  int status = 0;
  std::map<std::string, std::string> headers;  // by name in lower case
  // "" when there is no such header.
  const std::string& header(const std::string& name) const;
};

struct HttpAnswer : HttpHead {
  std::string body;
};

// Receives a body as it comes.
struct HttpReceiver {
  // Returns true if body() shall get the body; otherwise it becomes HttpAnswer::body.
  std::function<Result<bool>(const HttpHead&)> head;
  std::function<Status(std::string_view)> body;
};

class Connection {
 public:
  // `authorities` is a PEM file with trusted certificates; if empty, those of the system are used. Connects at the
  // first request. Error io when the file cannot be read.
  static Result<Connection> make(ServerAddress address, const std::filesystem::path& authorities);
  Connection(Connection&&) noexcept;
  ~Connection();

  // Sends a request and returns the answer. Errors: io when there is no answer, or the connection ends or is silent;
  // usage when the peer is not trusted or does not speak HTTP; interrupted; those of receiver and source. All but the
  // last begin with the server's address.
  Result<HttpAnswer> ask(const HttpRequest& request, const std::stop_token& stop, const HttpReceiver& receiver = {});

 private:
  struct Impl;  // keeps Beast out of the other files
  explicit Connection(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::client
