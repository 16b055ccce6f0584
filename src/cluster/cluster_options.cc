#include "src/cluster/cluster_options.h"

#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <memory>

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

Result<std::vector<HostPort>> addresses_of(const HostPort& named) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* first = nullptr;
  const int failed = ::getaddrinfo(named.host.c_str(), nullptr, &hints, &first);
  if (failed != 0) return error(Errc::io, named.host + ": " + ::gai_strerror(failed));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> list(first, &::freeaddrinfo);
  std::vector<HostPort> addresses;
  for (const addrinfo* at = list.get(); at; at = at->ai_next) {
    std::array<char, NI_MAXHOST> text{};
    if (::getnameinfo(at->ai_addr, at->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) != 0) continue;
    const HostPort address{text.data(), named.port};
    if (std::find(addresses.begin(), addresses.end(), address) == addresses.end()) addresses.push_back(address);
  }
  if (addresses.empty()) return error(Errc::io, named.host + ": has no address");
  return addresses;
}

}  // namespace tessera
