// HTTP/1.1 to one server, over TCP or TLS: one request at a time, on a connection that is kept.
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

namespace tessera {

struct HttpRequest {
  std::string method = "GET";
  std::string target;  // path and query, as they are sent
  std::map<std::string, std::string> headers = {};
  std::string body = {};
  // Instead of `body`: so many bytes, a piece at a time; it fills the beginning of what it is given, with 1 byte at
  // least, and says how many it were. Not repeatable.
  std::uint64_t source_bytes = 0;
  std::function<Result<std::size_t>(std::span<char>)> source = {};
  // Whether it may be sent a second time, when the server has closed the kept connection just then.
  bool repeatable = true;
  std::chrono::seconds silence{60};  // the longest time without any byte
};

struct HttpHead {
  int status = 0;
  std::map<std::string, std::string> headers;  // by name in lower case
  // "" when there is none.
  const std::string& header(const std::string& name) const;
};

struct HttpAnswer : HttpHead {
  std::string body;
};

// Takes a body as it comes.
struct HttpReceiver {
  // Whether body() shall have it; otherwise it becomes HttpAnswer::body.
  std::function<Result<bool>(const HttpHead&)> head;
  std::function<Status(std::string_view)> body;
};

class Connection {
 public:
  // `authorities`: a PEM file with the certificates to trust; those of the system when empty. Error io when it cannot
  // be read. Connects when it is needed.
  static Result<Connection> make(ServerAddress address, const std::filesystem::path& authorities);
  Connection(Connection&&) noexcept;
  ~Connection();

  // Errors: io when nobody answers, the connection ends or is silent, and what receiver and source return; usage when
  // what answers is not trusted or speaks no HTTP; interrupted. All but the receiver's and the source's begin with the
  // server's address.
  Result<HttpAnswer> ask(const HttpRequest& request, const std::stop_token& stop, const HttpReceiver& receiver = {});

 private:
  struct Impl;  // keeps Beast out of the other files
  explicit Connection(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
