// What stands in the first line of a request: a path and a query, decoded once, or refused. Only origin-form
// ("/a/b?c=d").
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/result.h"

namespace tessera::http {

struct Target {
  std::string path;                   // as it was sent, without the query
  std::vector<std::string> segments;  // decoded; "/" has none
  std::vector<std::pair<std::string, std::string>> query;

  // Empty when it is not there.
  std::optional<std::string_view> parameter(std::string_view name) const;
};

// Error usage: anything that two programs could read differently: "." and "..", empty segments, encoded slashes,
// backslashes and percent signs before two digits, control characters, text that is no UTF-8, a parameter given twice.
Result<Target> parse_target(std::string_view target);

// Letters, digits and -._~ as they are, everything else as %XX.
std::string encode_segment(std::string_view text);

// The reference (RFC 3986, 4.2) that leads from the page at path `from` to the one at path `to`; both begin with a
// slash.
std::string relative_reference(std::string_view from, std::string_view to);

}  // namespace tessera::http
