// Who may ask, from where: hosts, tokens, cookies, origins.
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

namespace tessera::http {

// How often an address may fail: `burst` times at once, then `per_second`. A right token is never refused for what
// others at its address did: it has 256 bits, so that no rate makes guessing it worth while; the bound spares log and
// processor.
class FailureRate {
 public:
  using Clock = std::chrono::steady_clock;
  FailureRate(double burst, double per_second) : burst_(burst), per_second_(per_second) {}
  // Counts one; false when there were too many.
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

// The host of a Host header or an origin's authority, in lower case, without its port; empty when it is none.
std::string host_of(std::string_view authority);

class Guard {
 public:
  // `hosts`: names allowed in Host beside those of this machine's loopback and of the public address.
  Guard(const Tokens& tokens, Sessions& sessions, const std::vector<std::string>& hosts, std::string_view public_url);

  // The answer to refuse with, if any. Sets request.caller.
  std::optional<Answer> check_host(const Request& request, Place place) const;
  // Whoever asks, if it can be told: true when what was shown is wrong.
  struct Shown {
    bool wrong = false, by_cookie = false;
  };
  Shown identify(Request& request) const;
  std::optional<Answer> check_role(const Request& request, const Shown& shown, Role needed);
  // A browser sends its cookie for every page that asks it to; only our own pages may.
  std::optional<Answer> check_origin(const Request& request, const Shown& shown) const;
  // A session in exchange for the token that the request shows: the answer has its cookie.
  Answer sign_in(const Request& request);
  // The session of the request's cookie ends, and the browser forgets the cookie.
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

}  // namespace tessera::http
