// The address of a server, and paths below it.
#pragma once

#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera::client {

struct ServerAddress {
  bool tls = false;
  std::string host;   // a name or an IP address, without brackets
  std::string port;   // a number
  std::string base;   // the path of the service: "" or "/tessera"
  std::string token;  // "" when the address has none
  bool operator==(const ServerAddress&) const = default;

  // "http://127.0.0.1:7070", for people: without the token.
  std::string text() const;
  // The value of the header Host: "[::1]:7070".
  std::string authority() const;
};

// Parses "http://127.0.0.1:7070", "https://host/tessera/", or the address with a token as the daemon prints it,
// "http://127.0.0.1:7070/#token=...". Error usage for everything else.
Result<ServerAddress> parse_address(std::string_view text);

// Encodes a part of a path or a value of a query: all but letters, digits and -._~ become %XX.
std::string percent_encoded(std::string_view text);

// Resolves a link in the answer to `path` (RFC 3986, 5.2). Returns a path with its query. A link to another scheme or
// host is an error of the server: io.
Result<std::string> follow_link(const ServerAddress& server, std::string_view path, std::string_view href);

}  // namespace tessera::client
