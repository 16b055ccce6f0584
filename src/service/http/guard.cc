#include "src/service/http/guard.h"

#include <arpa/inet.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace tessera::service::http {
namespace {

// A header that comes twice could be read differently here and by a proxy in front.
constexpr std::string_view once[] = {"host",     "authorization",   "content-type",  "origin",        "range",
                                     "if-range", "idempotency-key", "last-event-id", "upload-offset", "sec-fetch-site"};

bool is_address(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> binary{};
  if (host.starts_with('[') && host.ends_with(']'))
    return inet_pton(AF_INET6, host.substr(1, host.size() - 2).c_str(), binary.data()) == 1;
  return inet_pton(AF_INET, host.c_str(), binary.data()) == 1;
}

// The value of this cookie in "a=b; c=d".
std::string_view cookie(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(';'), header.size());
    std::string_view pair = header.substr(0, end);
    header.remove_prefix(std::min(end + 1, header.size()));
    while (pair.starts_with(' ')) pair.remove_prefix(1);
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=')
      return pair.substr(name.size() + 1);
  }
  return {};
}

bool has_scheme(std::string_view value, std::string_view scheme) {
  return value.size() > scheme.size() && std::equal(scheme.begin(), scheme.end(), value.begin(), [](char a, char b) {
           return a == (b >= 'A' && b <= 'Z' ? b + 32 : b);
         });
}

// The password in "Basic ..." (RFC 7617), with any user name.
std::optional<std::string> password_of(std::string_view value) {
  constexpr std::string_view scheme = "basic ";
  if (!has_scheme(value, scheme)) return std::nullopt;
  value.remove_prefix(scheme.size());
  std::string pair(value.size() / 4 * 3 + 3, '\0');
  const int bytes =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(pair.data()),
                      reinterpret_cast<const unsigned char*>(value.data()), static_cast<int>(value.size()));
  if (bytes < 0) return std::nullopt;
  pair.resize(static_cast<std::size_t>(bytes));
  while (!pair.empty() && pair.back() == '\0') pair.pop_back();  // decoding also counts the bytes of '='
  const std::size_t colon = pair.find(':');
  return colon == std::string::npos ? std::nullopt : std::optional(pair.substr(colon + 1));
}

// The token in "Bearer ..."; nothing otherwise.
std::optional<std::string_view> bearer_of(std::string_view value) {
  constexpr std::string_view scheme = "bearer ";
  if (!has_scheme(value, scheme)) return std::nullopt;
  return value.substr(scheme.size());
}

bool changes_state(std::string_view method) { return method != "GET" && method != "HEAD" && method != "OPTIONS"; }

}  // namespace

bool FailureRate::allow(const std::string& address, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  // When the table is full, all addresses begin anew. So the table stays small, which is enough.
  if (buckets_.size() >= addresses_max && !buckets_.contains(address)) buckets_.clear();
  const auto [at, fresh] = buckets_.try_emplace(address, Bucket{burst_, now});
  Bucket& bucket = at->second;
  const double seconds = std::chrono::duration<double>(now - bucket.at).count();
  bucket.left = std::min(burst_, bucket.left + seconds * per_second_);
  bucket.at = now;
  if (bucket.left < 1) return false;
  bucket.left -= 1;
  return true;
}

std::string host_of(std::string_view authority) {
  std::string host(authority);
  std::transform(host.begin(), host.end(), host.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  const std::size_t end = host.starts_with('[') ? host.find(']') : host.find(':');
  std::string port;
  if (host.starts_with('[')) {
    if (end == std::string::npos) return {};
    port = host.substr(end + 1);
    host.resize(end + 1);
  } else if (end != std::string::npos) {
    port = host.substr(end);
    host.resize(end);
  }
  if (!port.empty() && (port[0] != ':' || port.find_first_not_of("0123456789", 1) != std::string::npos)) return {};
  if (host.ends_with('.')) host.pop_back();
  return host;
}

Guard::Guard(const Tokens& tokens, Sessions& sessions, const std::vector<std::string>& hosts,
             std::string_view public_url)
    : tokens_(tokens), sessions_(sessions), hosts_{"localhost", "127.0.0.1", "[::1]"} {
  for (const std::string& host : hosts) hosts_.insert(host_of(host));
  const std::size_t authority = public_url.find("://");
  if (authority == std::string_view::npos) return;
  public_origin_ = public_url.substr(0, public_url.find('/', authority + 3));
  hosts_.insert(host_of(std::string_view(public_origin_).substr(authority + 3)));
}

std::optional<Answer> Guard::check_host(const Request& request, Place place) const {
  for (const std::string_view name : once)
    if (request.count(name) > 1) return problem(400, "the header " + std::string(name) + " is given twice", 2);
  if (request.count("host") == 0) return problem(400, "the header Host is missing", 2);
  const std::string host = host_of(request.header("host"));
  if (hosts_.contains(host)) return std::nullopt;
  // A supervisor uses an address. Attacks by DNS rebinding need a name.
  if (place == Place::operations && is_address(host)) return std::nullopt;
  return problem(421, "Host: the service does not have this name", 2);
}

Guard::Shown Guard::identify(Request& request) const {
  Shown shown;
  std::optional<Caller> caller;
  if (request.count("authorization") > 0) {
    std::string_view value = request.header("authorization");
    if (const auto token = bearer_of(value)) {
      caller = tokens_.find(*token);
    } else if (const auto password = password_of(value)) {
      // For programs that know only user names and passwords. Browsers send passwords unasked, so they give the right
      // to read only, whatever the token's role.
      caller = tokens_.find(*password);
      if (caller) caller->role = std::min(caller->role, Role::read);
    }
    shown.wrong = !caller;
  } else if (const std::string_view session = cookie(request.header("cookie"), cookie_name(request));
             !session.empty()) {
    const auto mark = sessions_.find(session, Sessions::Clock::now());
    if (mark) caller = tokens_.find_mark(*mark);
    shown.by_cookie = caller.has_value();
    shown.wrong = !caller;
  }
  request.caller = caller.value_or(Caller{});
  return shown;
}

Answer Guard::refuse(const Request& request, bool wrong) {
  if (wrong && !failures_.allow(request.remote, FailureRate::Clock::now())) {
    Answer answer = problem(429, "too many wrong tokens from this address");
    answer.close = true;  // otherwise many guesses on one connection would cost little
    return answer;
  }
  Answer answer = problem(401, wrong ? "the service does not know this token" : "a token is needed");
  answer.headers.emplace_back("WWW-Authenticate", "Bearer realm=\"tessera\"");
  return answer;
}

std::optional<Answer> Guard::check_role(const Request& request, const Shown& shown, Role needed) {
  if (needed == Role::none || request.caller.role >= needed) return std::nullopt;
  if (request.caller.role == Role::none) return refuse(request, shown.wrong);
  return problem(403, "this needs a token of role " + std::string(word_of(needed)) + ", and " + request.caller.name +
                          " has role " + std::string(word_of(request.caller.role)));
}

std::optional<Answer> Guard::check_origin(const Request& request, const Shown& shown) const {
  if (!shown.by_cookie || !changes_state(request.method)) return std::nullopt;
  const std::string_view site = request.header("sec-fetch-site"), origin = request.header("origin");
  // The same scheme, host and port: the page came from the address that the browser asks.
  const std::string own = (request.tls ? "https://" : "http://") + std::string(request.header("host"));
  const bool same = origin.empty()
                        ? site == "same-origin"
                        : (origin == own || origin == public_origin_) && (site.empty() || site == "same-origin");
  if (same) return std::nullopt;
  return problem(403, "the request comes from a page of another origin");
}

Answer Guard::sign_in(const Request& request) {
  const auto token = bearer_of(request.header("authorization"));
  if (!token) return problem(400, "a session begins with a token, in the header Authorization: Bearer", 2);
  const auto session = sessions_.begin(Tokens::mark_of(*token), Sessions::Clock::now());
  if (!session) return problem(500, session.error().where, static_cast<int>(session.error().code));
  Answer answer;
  answer.status = 204;
  answer.headers.emplace_back("Set-Cookie", set_cookie(request, session.value(), Sessions::lifetime));
  return answer;
}

Answer Guard::sign_out(const Request& request) {
  const std::string_view session = cookie(request.header("cookie"), cookie_name(request));
  if (const Status ended = sessions_.end(session); !ended)
    return problem(500, ended.error().where, static_cast<int>(ended.error().code));
  Answer answer;
  answer.status = 204;
  answer.headers.emplace_back("Set-Cookie", set_cookie(request, "", std::chrono::seconds(0)));
  return answer;
}

std::string Guard::set_cookie(const Request& request, const std::string& session, std::chrono::seconds lifetime) {
  return cookie_name(request) + "=" + session +
         "; Path=/; HttpOnly; SameSite=Strict; Max-Age=" + std::to_string(lifetime.count()) +
         (request.tls ? "; Secure" : "");
}

// One name a port, because browsers share cookies among all ports of a host.
std::string Guard::cookie_name(const Request& request) { return "tessera-" + std::to_string(request.port); }

}  // namespace tessera::service::http
