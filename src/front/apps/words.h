// The names of options in the messages of the command: its flags.
#pragma once

#include <string>
#include <string_view>

namespace tessera::apps {

// Returns how a message names the option `key`, with its `value` if there is one: "--memory" for ("memory", ""), "--dim
// 2" for ("dim", "2"), "--overwrite" for ("overwrite", "true"), "--no-z" for ("z", "false").
std::string flag_name(std::string_view key, std::string_view value);

}  // namespace tessera::apps
