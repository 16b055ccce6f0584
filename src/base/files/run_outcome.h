// The name of a file in run folders.
#pragma once

#include <filesystem>

namespace tessera {

// What the run has made. It is written just before the outcome gets its place, and is the last file that is removed.
inline std::filesystem::path outcome_file(const std::filesystem::path& run) { return run / "outcome.json"; }

}  // namespace tessera
