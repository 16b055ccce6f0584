#include "src/cluster/cluster_options.h"

#include <charconv>

namespace tessera {

Result<HostPort> parse_host_port(const std::string& text) {
  const auto refuse = [&] { return error(Errc::usage, "'" + text + "' is not HOST:PORT"); };
  const auto colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return refuse();
  HostPort out;
  out.host = text.substr(0, colon);
  if (out.host.front() == '[' && out.host.back() == ']') {
    out.host = out.host.substr(1, out.host.size() - 2);
  } else if (out.host.find(':') != std::string::npos) {
    return refuse();
  }
  const char* const first = text.data() + colon + 1;
  const char* const last = text.data() + text.size();
  const auto [end, wrong] = std::from_chars(first, last, out.port);
  if (wrong != std::errc{} || end != last || out.host.empty()) return refuse();
  return out;
}

std::string to_string(const HostPort& address) {
  const bool bare = address.host.find(':') == std::string::npos;
  return (bare ? address.host : "[" + address.host + "]") + ":" + std::to_string(address.port);
}

}  // namespace tessera
