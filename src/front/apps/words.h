// How the command names options in its sentences: as its flags.
#pragma once

#include <string>
#include <string_view>

namespace tessera {

// ("memory", "") is "--memory", ("dim", "2") "--dim 2", ("overwrite", "true") "--overwrite", ("z", "false") "--no-z".
std::string flag_name(std::string_view key, std::string_view value);

}  // namespace tessera
