// Decides who may ask, and from where: hosts, tokens, cookies, origins.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "src/service/http/message.h"
#include "src/service/http/router.h"
#include "src/service/http/sessions.h"
#include "src/service/http/tokens.h"

namespace tessera::service::http {

// Limits how often an address may fail: `burst` times at once, then `per_second`. A right token is never refused
// because of others at its address. Tokens have 256 bits, so they cannot be guessed at any rate; the limit only spares
// log and processor.
class FailureRate {
 public:
  using Clock = std::chrono::steady_clock;
  FailureRate(double burst, double per_second) : burst_(burst), per_second_(per_second) {}
  // Counts a failure; returns false when there were too many.
  bool allow(const std::string& address, Clock::time_point now);

 private:
  static constexpr std::size_t addresses_max = 4096;
  struct Bucket {
    double left = 0;
    Clock::time_point at;
  };
  double burst_, per_second_;
  std::mutex mutex_;
  std::unordered_map<std::string, Bucket> buckets_;
};

// The host of a Host header or of an origin's authority, in lower case, without the port; empty when it is invalid.
std::string host_of(std::string_view authority);

class Guard {
 public:
  // `hosts` are names that Host may have, in addition to those of the loopback and of the public address.
  Guard(const Tokens& tokens, Sessions& sessions, const std::vector<std::string>& hosts, std::string_view public_url);

  // Returns an answer when the host is refused.
  std::optional<Answer> check_host(const Request& request, Place place) const;
  // Finds the caller, and sets request.caller. `wrong` is true when the token or cookie is invalid.
  struct Shown {
    bool wrong = false, by_cookie = false;
  };
  Shown identify(Request& request) const;
  std::optional<Answer> check_role(const Request& request, const Shown& shown, Role needed);
  // A browser sends its cookie with requests of any page. Only our own pages are allowed.
  std::optional<Answer> check_origin(const Request& request, const Shown& shown) const;
  // Begins a session for the token in the request. The answer sets its cookie.
  Answer sign_in(const Request& request);
  // Ends the session of the request's cookie, and makes the browser forget the cookie.
  Answer sign_out(const Request& request);

 private:
  Answer refuse(const Request& request, bool wrong);
  static std::string cookie_name(const Request& request);
  static std::string set_cookie(const Request& request, const std::string& session, std::chrono::seconds lifetime);

  const Tokens& tokens_;
  Sessions& sessions_;
  std::set<std::string> hosts_;
  std::string public_origin_;
  FailureRate failures_{20, 1};
};

}  // namespace tessera::service::http
