// The names of what a result has beside it while it is kept in memory and changed (src/delaunay/live).
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>

namespace tessera {

inline std::filesystem::path live_folder(const std::filesystem::path& out) { return out / ".live"; }
// The log of the changes since version `version` of the result: OUT/.live/000001.log.
inline std::filesystem::path live_log_file(const std::filesystem::path& out, std::uint32_t version) {
  char name[24];
  std::snprintf(name, sizeof name, "%06u.log", version);
  return live_folder(out) / name;
}

}  // namespace tessera
