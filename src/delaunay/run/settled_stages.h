// Which stages of a run are settled: all tiles were quiet in them, and have left what each needs to come to its end.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/result.h"

namespace tessera {

// How many stages of a run are settled, of so many: the first of those that are not goes on, or begins. Error io.
Result<std::uint32_t> settled_stages(const std::filesystem::path& run, std::uint32_t stages);
// Writes down that all tiles were quiet in a stage and are independent of each other now; or that they are not, and
// then what made them so goes. `lock_file` as in ShareOptions.
Status mark_settled(const std::filesystem::path& run, std::uint32_t stage, const std::filesystem::path& lock_file,
                    bool settled);

}  // namespace tessera
