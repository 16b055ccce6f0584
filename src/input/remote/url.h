// Addresses of objects, checked.
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera::remote {

struct Url {
  std::string address;  // what is asked for, with all its parameters
  std::string shown;    // without what follows '?', which may be a signature
  std::string scheme;   // "http" or "https"
  std::string host;     // in lower case; an IPv6 address without brackets
  std::string port;     // in digits, also when the address has none
  std::string path;     // "/a%20b/c.las", without dot segments
};

// Parses https://host[:port]/path[?parameters] or http://... Error usage for other schemes and for what is no such
// address; also for one with a user name or password, because it would be kept in results and in lists of processes.
Result<Url> parse_url(const std::string& text);

// Url::shown of any text, also of one that is no address.
std::string without_secrets(const std::string& text);

}  // namespace tessera::remote
