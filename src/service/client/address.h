// Where a server is, and the names under it.
#pragma once

#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera {

struct ServerAddress {
  bool tls = false;
  std::string host;   // a name or an IP address, without brackets
  std::string port;   // a number
  std::string base;   // the path under which the service is: "" or "/tessera"
  std::string token;  // "" when the address has none
  bool operator==(const ServerAddress&) const = default;

  // "http://127.0.0.1:7070", as people read it: without the token.
  std::string text() const;
  // As the header Host has it: "[::1]:7070".
  std::string authority() const;
};

// "http://127.0.0.1:7070", "https://host/tessera/", or the address with its token as the daemon prints it,
// "http://127.0.0.1:7070/#token=...". Error usage for everything else.
Result<ServerAddress> parse_address(std::string_view text);

// One part of a path or a value of a query: all but letters, digits and -._~ as %XX.
std::string percent_encoded(std::string_view text);

// The path that a link leads to, with its query, from the answer to `path` (RFC 3986, 5.2). A link to another scheme or
// host is an error of the server: io.
Result<std::string> follow_link(const ServerAddress& server, std::string_view path, std::string_view href);

}  // namespace tessera
