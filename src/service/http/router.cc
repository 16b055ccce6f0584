#include "src/service/http/router.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tessera::service::http {
namespace {

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> segments;
  path.remove_prefix(1);
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    segments.emplace_back(path.substr(0, end));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return segments;
}

bool is_argument(std::string_view segment) { return segment.starts_with('{'); }
bool takes_the_rest(std::string_view segment) { return segment.ends_with("*}"); }

bool fits(const std::vector<std::string>& wanted, const std::vector<std::string>& segments) {
  const bool rest = !wanted.empty() && takes_the_rest(wanted.back());
  // Most routes differ in their number of segments, so that is compared first.
  if (rest ? segments.size() < wanted.size() : segments.size() != wanted.size()) return false;
  for (std::size_t at = 0; at < wanted.size(); ++at)
    if (!is_argument(wanted[at]) && wanted[at] != segments[at]) return false;
  return true;
}

std::vector<std::string> arguments_of(const std::vector<std::string>& wanted,
                                      const std::vector<std::string>& segments) {
  std::vector<std::string> arguments;
  for (std::size_t at = 0; at < wanted.size(); ++at)
    if (is_argument(wanted[at])) arguments.push_back(segments[at]);
  if (!wanted.empty() && takes_the_rest(wanted.back()))
    for (std::size_t at = wanted.size(); at < segments.size(); ++at) arguments.back() += "/" + segments[at];
  return arguments;
}

}  // namespace

HttpRouter::HttpRouter(std::vector<Route> routes) : routes_(std::move(routes)) {
  for (const Route& route : routes_) templates_.push_back(split(route.path));
}

const Route* HttpRouter::find(Place place, std::string_view method, const std::vector<std::string>& segments,
                              std::vector<std::string>& arguments, std::vector<std::string>& allowed) const {
  const Route* found = nullptr;
  const Route* as_get = nullptr;
  for (std::size_t at = 0; at < routes_.size(); ++at) {
    const Route& route = routes_[at];
    if (route.place != place || !fits(templates_[at], segments)) continue;
    allowed.push_back(route.method);
    if (route.method == method) found = &route;
    if (route.method == "GET" && method == "HEAD") as_get = &route;
    if (found == &route || as_get == &route) arguments = arguments_of(templates_[at], segments);
  }
  if (allowed.empty()) return nullptr;
  const auto has = [&](std::string_view name) {
    return std::find(allowed.begin(), allowed.end(), name) != allowed.end();
  };
  if (has("GET") && !has("HEAD")) allowed.emplace_back("HEAD");
  if (!has("OPTIONS")) allowed.emplace_back("OPTIONS");
  return found ? found : as_get;
}

}  // namespace tessera::service::http
