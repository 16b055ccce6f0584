// The addresses that a process may ask when strangers name them: those below prefixes that its operator lists.
#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera::remote {

// Immutable, so thread-safe.
class Permits {
 public:
  // Prefixes: https://host[:port][/folder], http://..., s3://bucket[/folder]. Error usage for anything else.
  static Result<Permits> parse(const std::vector<std::string>& prefixes);

  // Whether an address by HTTP, or a name s3://bucket/..., lies below a prefix. Compared are scheme, host, port (or the
  // bucket) and whole segments of the path, as a server would read them. Error usage, naming `shown`: none of the
  // prefixes fits, or the path could be read in several ways (encoded dots and slashes, codes of codes).
  Status check_address(const std::string& address, const std::string& shown) const;
  Status check_s3(const std::string& name) const;

 private:
  struct Place {
    std::string scheme, host, port;  // of s3: "s3", the bucket, ""
    std::vector<std::string> path;   // decoded segments
  };
  static Result<Place> place_of(const std::string& address, const std::string& shown);
  static Result<Place> place_of_s3(const std::string& name);
  Status check(const Place& place, const std::string& shown) const;

  std::vector<Place> prefixes_;
};

// Whether a connection to this address may end at this machine itself or at what serves machines about themselves:
// loopback, link-local, unspecified, multicast and reserved addresses, and the known addresses of metadata of clouds;
// for IPv6 also those that hold such an address of IPv4.
bool leads_inward(const sockaddr& address);

// The number of an address, as people write it: "127.0.0.1", "::1".
std::string address_number(const sockaddr& address);

// Whether `host` is this very address, written as a number.
bool is_number_of(const std::string& host, const sockaddr& address);

}  // namespace tessera::remote
