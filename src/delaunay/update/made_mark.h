// A mark in the run folder of a change, which says what the run has made. It is written just before the new manifest
// gets its place, and is the last that is removed. So a process that was killed after its last rename has left the mark
// of a result that exists, and one that was killed before has left none, or the mark of another manifest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

struct MadeMark {
  std::string manifest;              // the checksum of the manifest
  std::vector<std::string> command;  // that made the change
};

// Error io.
Status write_mark(const std::filesystem::path& run, const MadeMark& mark);
// Nothing when there is none. Errors: corrupt, io.
Result<std::optional<MadeMark>> read_mark(const std::filesystem::path& run);
// Whether `out` has the manifest that the mark names. Error io.
Result<bool> is_made(const MadeMark& mark, const std::filesystem::path& out);

}  // namespace tessera
