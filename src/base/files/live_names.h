// The names of what a result has beside it while it is kept in memory and changed (src/delaunay/live).
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/files/names.h"

namespace tessera {

inline std::filesystem::path live_folder(const std::filesystem::path& out) { return out / ".live"; }
// The log of the changes since version `version` of the result: OUT/.live/000001.log.
inline std::filesystem::path live_log_file(const std::filesystem::path& out, std::uint32_t version) {
  return live_folder(out) / version_file("", version).filename().replace_extension(".log");
}

}  // namespace tessera
