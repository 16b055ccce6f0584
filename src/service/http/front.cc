#include "src/service/http/front.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace tessera::service::http {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

bool has(const Headers& headers, std::string_view name) {
  return std::any_of(headers.begin(), headers.end(), [&](const auto& header) { return header.first == name; });
}

bool is_page(const Headers& headers) {
  return std::any_of(headers.begin(), headers.end(), [](const auto& header) {
    return header.first == "Content-Type" && header.second.starts_with("text/html");
  });
}

// True for answers to callers without the right.
bool is_refusal(int status) { return status == 401 || status == 403 || status == 429; }

std::string name_of(const Request& request) { return request.caller.name.empty() ? "nobody" : request.caller.name; }

// The caller, the request and its outcome: the job of a submission, or the reason of a refusal.
std::string audit_line(const Request& request, const Answer& answer, const std::string& why) {
  std::string outcome = std::to_string(answer.status);
  for (const auto& [name, value] : answer.headers)
    if (name == "Location") outcome += ", " + value;
  if (!why.empty()) outcome += ", " + why;
  return "audit: " + name_of(request) + " (" + std::string(word_of(request.caller.role)) + ") from " + request.remote +
         ": " + request.method + " " + request.target.path + ": " + outcome;
}

void warn(const std::string& line) { spdlog::warn("{}", line); }

}  // namespace

Front::Front(const Backend& backend, Tokens tokens, FrontOptions options)
    : backend_(backend),
      tokens_(std::move(tokens)),
      sessions_(options.sessions),
      links_(options.public_url),
      guard_(tokens_, sessions_, options.hosts, options.public_url),
      router_(all_routes(shared_, *backend_)),
      context_{&*backend_, links_},
      refusals_(warn) {
  shared_.guard = &guard_;
}

Front::Front(const NodeHealth& node)
    : links_({}),
      guard_(tokens_, sessions_, {}, {}),
      router_(node_routes(shared_, node)),
      context_{nullptr, links_},
      refusals_(warn) {}

Status Front::load_sessions() { return sessions_.load(Sessions::Clock::now()); }

Status Front::replace_tokens(Tokens tokens) {
  tokens_.replace(std::move(tokens));
  return sessions_.end_unless([this](const std::string& mark) { return tokens_.find_mark(mark).has_value(); });
}

std::optional<Answer> Front::refusal(Request& request, Admitted& admitted, std::string_view target, Place place) {
  if (auto refused = guard_.check_host(request, place)) return refused;
  if (request.method == "OPTIONS" && target == "*") {
    Answer answer;
    answer.status = 204;
    answer.headers.emplace_back("Allow", "DELETE, GET, HEAD, OPTIONS, POST, PUT");
    return answer;
  }
  // Clients of the standard request the landing page with a slash at its end, and its links are then relative to that.
  // The same holds for the dashboard.
  std::string without(target);
  const std::size_t end = std::min(target.find('?'), target.size());
  const bool slash = target.substr(0, end) == "/v1/" || target.substr(0, end) == "/ui/";
  if (slash) without.erase(end - 1, 1);
  Result<Target> parsed = parse_target(without);
  if (!parsed) return bad_request(parsed.error());
  request.target = std::move(parsed.value());
  if (slash) request.target.path += '/';
  std::vector<std::string> allowed;
  admitted.route = router_.find(place, request.method, request.target.segments, admitted.arguments, allowed);
  if (allowed.empty()) return problem(404, "there is nothing at this address");
  if (!admitted.route) {
    std::sort(allowed.begin(), allowed.end());
    Answer answer = problem(405, "this address allows only " + joined(allowed));
    if (request.method == "OPTIONS") {
      answer = Answer{};
      answer.status = 204;
    }
    answer.headers.emplace_back("Allow", joined(allowed));
    return answer;
  }
  // For any caller: the dashboard asks for a token.
  if (place == Place::api && request.target.path == "/" && request.method == "GET" && prefers(request, "text/html")) {
    Answer answer;
    answer.status = 303;
    answer.headers.emplace_back("Location", "ui/");
    return answer;
  }
  const Guard::Shown shown = guard_.identify(request);
  if (auto refused = guard_.check_role(request, shown, admitted.route->role)) {
    if (shown.wrong) metrics().count_failed_authentication();
    return refused;
  }
  if (auto refused = guard_.check_origin(request, shown)) return refused;
  const auto& known = admitted.route->query;
  for (const auto& given : request.target.query)
    if (std::none_of(known.begin(), known.end(), [&](const auto& parameter) { return parameter.name == given.first; }))
      return problem(400, "this address has no parameter '" + given.first + "'", 2);
  return std::nullopt;
}

Admitted Front::admit(Request& request, std::string_view target, Place place) {
  Admitted admitted;
  admitted.began = std::chrono::steady_clock::now();
  admitted.answer = refusal(request, admitted, target, place);
  return admitted;
}

Answer Front::answer(const Request& request, const Admitted& admitted) {
  try {
    Answer answer = admitted.route->handler({request, admitted.arguments, context_});
    // Checked last: then the answer was true while the data folder was this daemon's.
    const auto lost = context_.backend ? context_.backend->health.lost() : std::nullopt;
    return lost ? problem(503, *lost, static_cast<int>(Errc::io)) : std::move(answer);
  } catch (const std::exception& failure) {
    spdlog::error("{} {}: {}", request.method, request.target.path, failure.what());
    return problem(500, "the service failed to answer this request; its log has the reason",
                   static_cast<int>(Errc::internal));
  }
}

Reply<std::unique_ptr<Upload>> Front::begin_upload(const Request& request, const Admitted& admitted) {
  return admitted.route->upload({request, admitted.arguments, context_});
}

void Front::complete(const Request& request, const Admitted& admitted, Answer& answer) {
  const std::string why = answer.problem ? answer.problem->detail() : "";
  write_problem(request, answer);
  Headers& headers = answer.headers;
  if (!has(headers, "Cache-Control")) headers.emplace_back("Cache-Control", "no-store");
  headers.emplace_back("X-Content-Type-Options", "nosniff");
  headers.emplace_back("X-Frame-Options", "DENY");
  headers.emplace_back("Referrer-Policy", "no-referrer");
  headers.emplace_back("Cross-Origin-Resource-Policy", "same-origin");
  // Makes browsers use only TLS for this name; not for "localhost", which other programs use, too.
  if (request.tls && host_of(request.header("host")) != "localhost")
    headers.emplace_back("Strict-Transport-Security", "max-age=31536000");
  // A report has its own style and pictures; it runs no scripts, and fetches nothing. The dashboard sets its own
  // policy.
  if (!has(headers, "Content-Security-Policy"))
    headers.emplace_back("Content-Security-Policy",
                         is_page(headers)
                             ? "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
                               "form-action 'none'; frame-ancestors 'none'"
                             : "default-src 'none'; frame-ancestors 'none'");
  const std::size_t place =
      admitted.route ? static_cast<std::size_t>(admitted.route - router_.routes().data()) : router_.routes().size();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - admitted.began;
  metrics().count(place, answer.status, seconds.count());
  if (!admitted.route) return;
  if (is_refusal(answer.status)) {
    refusals_.refused(name_of(request) + " from " + request.remote, audit_line(request, answer, why),
                      RefusalLog::Clock::now());
  } else if (request.method != "GET" && request.method != "HEAD") {
    spdlog::info("{}", audit_line(request, answer, why));
  }
}

}  // namespace tessera::service::http
