// The target in the first line of a request: a path and a query, decoded once, or refused. Only the origin form
// ("/a/b?c=d").
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/result.h"

namespace tessera::service::http {

struct Target {
  std::string path;                   // as it was sent, without the query
  std::vector<std::string> segments;  // decoded; "/" has none
  std::vector<std::pair<std::string, std::string>> query;

  // Nothing when there is no such parameter.
  std::optional<std::string_view> parameter(std::string_view name) const;
};

// Error usage for anything that two programs could read differently: "." and "..", empty segments, encoded slashes,
// backslashes, percent signs without two hexadecimal digits, control characters, text that is not UTF-8, a parameter
// that is given twice.
Result<Target> parse_target(std::string_view target);

// Keeps letters, digits and -._~, and encodes everything else as %XX.
std::string encode_segment(std::string_view text);

// The reference (RFC 3986, 4.2) from the page at path `from` to the page at path `to`; both begin with a slash.
std::string relative_reference(std::string_view from, std::string_view to);

}  // namespace tessera::service::http
