// Decimal text to the nearest double.
#pragma once

#include <optional>
#include <string_view>

namespace tessera {

// The double nearest to `text` ("-1.5e3", "+2", "nan", "inf"), whatever the locale; nothing if `text` is not wholly a
// number. Too large becomes infinity and too small zero, as rounding has it.
std::optional<double> parse_number(std::string_view text);

}  // namespace tessera
