// Requests of HTTP, many at once over connections that are kept. Source: RFC 9110, RFC 9112.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera::remote {

// How many requests of a process are under way at once.
inline constexpr int in_flight_max = 16;

// How long a server may be silent or slow.
struct Patience {
  long connect_ms = 10'000;
  // A transfer of fewer bytes a second than that, on average over so many seconds, is given up.
  long slow_bytes = 1024, slow_s = 20;
  long whole_s = 300;  // one request, whatever comes
  // The same for requests that send something: stores take their time to put parts together, and lines to send.
  long slow_write_s = 120, whole_write_s = 3600;
};

// Who signs requests (Signature Version 4 of AWS).
struct Signing {
  std::string key, secret;
  std::string token;  // of credentials that are valid for some hours; or empty
};

struct HttpRequest {
  std::string address;
  std::string range;  // "0-16383"; empty: the whole answer is wanted
  std::string method = "GET";
  std::shared_ptr<const std::vector<std::byte>> body = {};  // what PUT and POST send; null: nothing
  std::vector<std::string> headers = {};
  std::shared_ptr<const Signing> signing = {};  // null: not signed
  std::string region = {};                      // for which the signature is
  std::size_t bytes_max = 0;                    // a longer body is an error
};

struct HttpReply {
  int status = 0;                              // 0: there was no answer
  std::map<std::string, std::string> headers;  // names in lower case
  std::vector<std::byte> body;                 // of status 206 or 200; of other answers the first bytes
  std::string failure;                         // why the answer is not whole; empty if it is
  bool passing = false;                        // the failure may be gone at the next try
  std::string redirect;                        // where an answer of status 3xx leads
};

class Permits;

// Thread-safe. One thread of this object moves all bytes.
class Transfers {
 public:
  // `ca_file`: certificates (PEM) that https trusts; empty: those of the system. `permits`: if given, no proxy is used,
  // and no connection is made to an address that leads inward (permits.h), unless the host of the request is the number
  // of this address. The address is that of the connection itself, whatever a name has meant before. What calls run()
  // checks the requests. REQUIRES: curl_library() has succeeded.
  explicit Transfers(const Patience& patience, std::string ca_file = {}, std::shared_ptr<const Permits> permits = {});
  Transfers(const Transfers&) = delete;
  Transfers& operator=(const Transfers&) = delete;
  // REQUIRES: no call of run() is under way. In a child that was forked since, where the thread does not exist, this is
  // the only function that may be called.
  ~Transfers();

  const Permits* permits() const;  // null: there are none

  // Sends the requests, and returns their replies in the same order. Redirects are not followed. Error interrupted soon
  // after `stop`.
  Result<std::vector<HttpReply>> run(const std::vector<HttpRequest>& requests, const std::stop_token& stop);

 private:
  struct Impl;  // keeps libcurl out of other files
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::remote
