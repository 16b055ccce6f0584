#include "src/input/remote/permits.h"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/remote/s3.h"
#include "src/input/remote/url.h"

namespace tessera::remote {
namespace {

std::optional<int> digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return {};
}

// A segment of a path without %XX. Nothing for a segment that servers and proxies read in different ways.
std::optional<std::string> plain_segment(std::string_view segment) {
  std::string plain;
  for (std::size_t i = 0; i < segment.size(); ++i) {
    char c = segment[i];
    if (c == '%') {
      if (i + 2 >= segment.size()) return {};
      const auto high = digit_of(segment[i + 1]), low = digit_of(segment[i + 2]);
      if (!high || !low) return {};
      c = static_cast<char>(*high * 16 + *low);
      i += 2;
      if (c == '%') return {};  // would be decoded twice
    }
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return {};
    plain += c;
  }
  const std::string_view name = std::string_view(plain).substr(0, plain.find(';'));  // "..;" is ".." to some servers
  if (name == "." || name == "..") return {};
  return plain;
}

std::optional<std::vector<std::string>> segments_of(std::string_view path) {
  std::vector<std::string> segments;
  if (path.starts_with('/')) path.remove_prefix(1);
  while (true) {
    const auto slash = path.find('/');
    auto plain = plain_segment(path.substr(0, slash));
    if (!plain) return {};
    segments.push_back(*std::move(plain));
    if (slash == std::string_view::npos) return segments;
    path.remove_prefix(slash + 1);
  }
}

Error has_tricks(const std::string& shown) {
  return error(Errc::usage, shown + ": has dots, slashes or codes in its path that can be read in several ways");
}

// A network of IPv6 or, with the first 96 bits of ::ffff:0:0/96, of IPv4.
struct Network {
  std::array<unsigned char, 16> begin;
  unsigned bits;
};

constexpr Network v4(unsigned a, unsigned b, unsigned c, unsigned d, unsigned bits) {
  const auto byte = [](unsigned number) { return static_cast<unsigned char>(number); };
  return {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, byte(a), byte(b), byte(c), byte(d)}, 96 + bits};
}

// Source: IANA special-purpose address registries (RFC 6890); the addresses of metadata are those that the clouds'
// manuals give.
constexpr std::array inward_networks{
    v4(0, 0, 0, 0, 8),           // this host
    v4(127, 0, 0, 0, 8),         // loopback
    v4(169, 254, 0, 0, 16),      // link-local, with the metadata of most clouds
    v4(192, 0, 0, 0, 24),        // for protocols, with the metadata of Oracle's cloud
    v4(100, 100, 100, 200, 32),  // metadata of Alibaba's cloud
    v4(168, 63, 129, 16, 32),    // metadata of Microsoft's cloud
    v4(224, 0, 0, 0, 4),         // multicast
    v4(240, 0, 0, 0, 4),         // reserved, and broadcast
    Network{{0}, 127},           // unspecified, loopback
    Network{{0xfe, 0x80}, 10},   // link-local
    Network{{0xfe, 0xc0}, 10},   // site-local, which is no longer used
    Network{{0xff}, 8},          // multicast
    // Metadata of Amazon's cloud.
    Network{{0xfd, 0x00, 0x0e, 0xc2}, 32},
};

// Networks of IPv6 that hold an address of IPv4, and the byte at which it begins. Source: RFC 4291, 6052, 8215, 3056.
struct Holder {
  Network network;
  std::size_t at;
};
constexpr std::array holders{
    Holder{{{0}, 96}, 12},                                               // compatible
    Holder{{{0x00, 0x64, 0xff, 0x9b}, 96}, 12},                          // translated
    Holder{{{0x00, 0x64, 0xff, 0x9b, 0x00, 0x01}, 48}, 12},              // translated, in a local network
    Holder{{{0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0x00, 0x00}, 96}, 12},  // translated, as SIIT does
    Holder{{{0x20, 0x02}, 16}, 2},                                       // 6to4
};

using AddressBytes = std::array<unsigned char, 16>;

bool lies_in(const AddressBytes& address, const Network& network) {
  for (unsigned bit = 0; bit < network.bits; bit += 8) {
    const unsigned left = network.bits - bit, mask = left >= 8 ? 0xff : (0xff << (8 - left)) & 0xff;
    if (((address[bit / 8] ^ network.begin[bit / 8]) & mask) != 0) return false;
  }
  return true;
}

AddressBytes mapped(const unsigned char* v4_address) {
  AddressBytes bytes = v4(0, 0, 0, 0, 0).begin;
  std::copy_n(v4_address, 4, bytes.begin() + 12);
  return bytes;
}

// Addresses of IPv4 as those of IPv6. Nothing for other families.
std::optional<AddressBytes> bytes_of(const sockaddr& address) {
  if (address.sa_family == AF_INET)
    return mapped(reinterpret_cast<const unsigned char*>(&reinterpret_cast<const sockaddr_in&>(address).sin_addr));
  if (address.sa_family != AF_INET6) return {};
  AddressBytes bytes;
  std::memcpy(bytes.data(), &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr, bytes.size());
  return bytes;
}

bool is_inward(const AddressBytes& address) {
  return std::any_of(inward_networks.begin(), inward_networks.end(),
                     [&](const Network& network) { return lies_in(address, network); });
}

}  // namespace

bool leads_inward(const sockaddr& address) {
  const auto bytes = bytes_of(address);
  if (!bytes) return true;
  return is_inward(*bytes) || std::any_of(holders.begin(), holders.end(), [&](const Holder& holder) {
           return lies_in(*bytes, holder.network) && is_inward(mapped(bytes->data() + holder.at));
         });
}

std::string address_number(const sockaddr& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const void* number = address.sa_family == AF_INET
                           ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in&>(address).sin_addr)
                           : &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  return ::inet_ntop(address.sa_family, number, text.data(), text.size()) == nullptr ? "" : text.data();
}

bool is_number_of(const std::string& host, const sockaddr& address) {
  const auto bytes = bytes_of(address);
  AddressBytes named{};
  in_addr v4_named{};
  if (::inet_pton(AF_INET, host.c_str(), &v4_named) == 1)
    named = mapped(reinterpret_cast<const unsigned char*>(&v4_named));
  else if (::inet_pton(AF_INET6, host.c_str(), named.data()) != 1)
    return false;
  return bytes == named;
}

Result<Permits::Place> Permits::place_of(const std::string& address, const std::string& shown) {
  BOOST_OUTCOME_TRY(url, parse_url(address));
  auto path = segments_of(url.path);
  if (!path) return has_tricks(shown);
  return Place{url.scheme, url.host, url.port, *std::move(path)};
}

Result<Permits::Place> Permits::place_of_s3(const std::string& name) {
  const std::string place = name.substr(5);
  const auto slash = place.find('/');
  // A key is not decoded: what is sent is its code.
  std::vector<std::string> path;
  std::string_view key = slash == std::string::npos ? std::string_view() : std::string_view(place).substr(slash + 1);
  while (true) {
    const auto end = key.find('/');
    path.emplace_back(key.substr(0, end));
    if (path.back() == "." || path.back() == "..") return has_tricks(printable(name));
    if (end == std::string_view::npos) break;
    key.remove_prefix(end + 1);
  }
  return Place{"s3", place.substr(0, slash), "", std::move(path)};
}

Result<Permits> Permits::parse(const std::vector<std::string>& prefixes) {
  Permits permits;
  for (const auto& prefix : prefixes) {
    if (prefix.find_first_of("?#") != std::string::npos)
      return error(Errc::usage,
                   without_secrets(prefix) + ": a prefix has nothing behind its path, neither '?' nor '#'");
    BOOST_OUTCOME_TRY(place, is_s3(prefix) ? place_of_s3(prefix) : place_of(prefix, without_secrets(prefix)));
    if (place.host.empty()) return error(Errc::usage, printable(prefix) + ": names no bucket");
    if (place.path.back().empty()) place.path.pop_back();  // "/folder/" is "/folder"
    permits.prefixes_.push_back(std::move(place));
  }
  return permits;
}

Status Permits::check(const Place& place, const std::string& shown) const {
  for (const auto& prefix : prefixes_) {
    if (place.scheme != prefix.scheme || place.host != prefix.host || place.port != prefix.port) continue;
    if (place.path.size() >= prefix.path.size() &&
        std::equal(prefix.path.begin(), prefix.path.end(), place.path.begin()))
      return success();
  }
  return error(Errc::usage, shown + ": is not below one of the addresses that this service may read (remote-prefix)");
}

Status Permits::check_address(const std::string& address, const std::string& shown) const {
  BOOST_OUTCOME_TRY(place, place_of(address, shown));
  return check(place, shown);
}

Status Permits::check_s3(const std::string& name) const {
  BOOST_OUTCOME_TRY(place, place_of_s3(name));
  return check(place, printable(name));
}

}  // namespace tessera::remote
