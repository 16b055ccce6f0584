// Converts decimal text to the nearest double.
#pragma once

#include <optional>
#include <string_view>

namespace tessera {

// Returns the double nearest to `text` ("-1.5e3", "+2", "nan", "inf"), independently of the locale. Nothing if `text`
// is not one number as a whole. A number that is too large becomes infinity, and one that is too small becomes zero.
std::optional<double> parse_number(std::string_view text);

}  // namespace tessera
