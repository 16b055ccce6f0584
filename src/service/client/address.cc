#include "src/service/client/address.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <vector>

namespace tessera::client {
namespace {

constexpr std::string_view plain_scheme = "http://", tls_scheme = "https://";

std::string scheme_port(bool tls) { return tls ? "443" : "80"; }

bool is_port(std::string_view text) {
  std::uint16_t number = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), number);
  return ec == std::errc{} && end == text.data() + text.size() && number != 0;
}

bool is_host(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("-._:").find(c) != std::string_view::npos;
  });
}

// "/a/./b/../c" becomes "/a/c".
std::string without_dots(std::string_view path) {
  std::vector<std::string_view> parts;
  bool folder = false;
  while (!path.empty()) {
    path.remove_prefix(1);  // the slash
    const auto part = path.substr(0, path.find('/'));
    path.remove_prefix(part.size());
    folder = part == "." || part == "..";
    if (part == ".." && !parts.empty()) parts.pop_back();
    if (!folder) parts.push_back(part);
  }
  std::string result;
  for (const auto part : parts) result += "/" + std::string(part);
  return folder || result.empty() ? result + "/" : result;
}

}  // namespace

std::string ServerAddress::authority() const {
  const bool six = host.find(':') != std::string::npos;
  return (six ? "[" + host + "]" : host) + (port == scheme_port(tls) ? "" : ":" + port);
}

std::string ServerAddress::text() const { return std::string(tls ? tls_scheme : plain_scheme) + authority() + base; }

Result<ServerAddress> parse_address(std::string_view text) {
  // The message does not repeat the text, which may hold a token.
  const auto bad = [](const char* reason = "it is not an address like http://127.0.0.1:7070") {
    return error(Errc::usage, reason);
  };
  ServerAddress address;
  if (text.starts_with(tls_scheme)) {
    address.tls = true;
    text.remove_prefix(tls_scheme.size());
  } else if (text.starts_with(plain_scheme)) {
    text.remove_prefix(plain_scheme.size());
  } else {
    return bad();
  }
  const auto authority = text.substr(0, text.find_first_of("/?#"));
  text.remove_prefix(authority.size());
  if (authority.find('@') != std::string_view::npos) return bad("an address has no user and no password; give a token");
  auto port_at = authority.rfind(':');
  if (authority.starts_with('[')) {
    const auto end = authority.find(']');
    if (end == std::string_view::npos) return bad();
    address.host = authority.substr(1, end - 1);
    if (end + 1 < authority.size() && authority[end + 1] != ':') return bad();
    port_at = end + 1 < authority.size() ? end + 1 : std::string_view::npos;
  } else {
    address.host = authority.substr(0, port_at);
    if (address.host.find(':') != std::string::npos)
      return bad("an IPv6 address stands in brackets: http://[::1]:7070");
  }
  if (!is_host(address.host)) return bad();
  address.port =
      port_at == std::string_view::npos ? scheme_port(address.tls) : std::string(authority.substr(port_at + 1));
  if (!is_port(address.port)) return bad("its port is not a number from 1 to 65535");

  const auto path = text.substr(0, text.find_first_of("?#"));
  text.remove_prefix(path.size());
  address.base = path;
  while (address.base.ends_with('/')) address.base.pop_back();
  if (std::any_of(path.begin(), path.end(), [](unsigned char c) { return c <= 0x20 || c >= 0x7f; })) return bad();
  constexpr std::string_view with_token = "#token=";
  if (text.starts_with(with_token) || text.starts_with("?token=")) {  // as earlier daemons print it
    address.token = text.substr(with_token.size());
  } else if (!text.empty()) {
    return bad("nothing but a token may follow its path");
  }
  return address;
}

std::string percent_encoded(std::string_view text) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
        std::string_view("-._~").find(c) != std::string_view::npos) {
      encoded += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      encoded += {'%', digits[byte >> 4], digits[byte & 15]};
    }
  }
  return encoded;
}

Result<std::string> follow_link(const ServerAddress& server, std::string_view path, std::string_view href) {
  const auto foreign = [&] {
    return error(Errc::io, server.text() + ": the answer of the server links to another server: " + std::string(href));
  };
  href = href.substr(0, href.find('#'));
  if (href.starts_with(plain_scheme) || href.starts_with(tls_scheme)) {
    const auto rest = href.substr(href.find("//") + 2);
    const auto authority = rest.substr(0, rest.find_first_of("/?"));
    const auto parsed = parse_address(href.substr(0, href.size() - rest.size() + authority.size()));
    if (!parsed || parsed.value().host != server.host || parsed.value().port != server.port ||
        parsed.value().tls != server.tls)
      return foreign();
    href = rest.substr(authority.size());
    if (!href.starts_with('/')) return "/" + std::string(href);
  }
  if (href.starts_with("//") || href.find("://") < href.find_first_of("/?")) return foreign();
  const auto query_at = std::min(href.find('?'), href.size());
  const auto target = href.substr(0, query_at);
  const auto query = std::string(href.substr(query_at));
  const auto here = path.substr(0, path.find('?'));
  if (target.empty()) return std::string(here) + query;
  if (target.starts_with('/')) return without_dots(target) + query;
  return without_dots(std::string(here.substr(0, here.rfind('/') + 1)) + std::string(target)) + query;
}

}  // namespace tessera::client
