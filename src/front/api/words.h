// The names of options in the messages of the library: the names of functions of its option classes.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

// Returns how a message names the option `key` of the command, with its `value` if there is one: "memory_bytes" for
// ("memory", ""), "dimension(2)" for ("dim", "2"), "format(\"vtu\")" for ("format", "vtu").
std::string member_name(std::string_view key, std::string_view value);

}  // namespace tessera
