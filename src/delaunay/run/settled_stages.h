// Which stages of a run are settled: all tiles were quiet, and each has left what it needs to finish without the
// others.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/result.h"

namespace tessera {

// Returns how many of the `stages` stages of a run are settled. The next stage is the one that continues or begins.
// Error io.
Result<std::uint32_t> settled_stages(const std::filesystem::path& run, std::uint32_t stages);
// Writes down that a stage is settled. With `settled` false, removes that mark, and what the tiles left when they
// settled. `lock_file` as in ShareOptions.
Status mark_settled(const std::filesystem::path& run, std::uint32_t stage, const std::filesystem::path& lock_file,
                    bool settled);

}  // namespace tessera
