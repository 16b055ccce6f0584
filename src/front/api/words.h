// How the library names options in its sentences: as functions of its option classes.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

// ("memory", "") is "memory_bytes", ("dim", "2") "dimension(2)", ("format", "vtu") "format(\"vtu\")".
std::string member_name(std::string_view key, std::string_view value);

}  // namespace tessera
