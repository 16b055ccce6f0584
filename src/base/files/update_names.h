// Names of what the making of a changed result writes to disk.
#pragma once

#include <filesystem>
#include <string>

#include "src/base/ids.h"

namespace tessera {

// The folder in which the changed result `target` is made.
inline std::filesystem::path update_run_folder(std::filesystem::path target) {
  if (!target.has_filename()) target = target.parent_path();  // "next/"
  return target += ".update";
}
// What the tiles of a change must know.
inline std::filesystem::path update_change_file(const std::filesystem::path& run) { return run / "change.bin"; }
// What a first triangulation of the changed points must know, when the change is made that way.
inline std::filesystem::path update_anew_file(const std::filesystem::path& run) { return run / "anew.bin"; }
// What tiles were told of holes, and what they have become.
inline std::filesystem::path update_told_folder(const std::filesystem::path& run) { return run / "told"; }
inline std::filesystem::path update_ends_folder(const std::filesystem::path& run) { return run / "ends"; }
inline std::filesystem::path update_tile_file(const std::filesystem::path& folder, TileId tile) {
  return folder / (to_string(tile) + ".bin");
}
// The changed result, until it is whole.
inline std::filesystem::path update_result_folder(const std::filesystem::path& run) { return run / "result"; }
// The same, when tiles have grown too large and are split.
inline std::filesystem::path update_split_folder(const std::filesystem::path& run) { return run / "split"; }
// The same with computed columns.
inline std::filesystem::path update_columns_folder(const std::filesystem::path& run) { return run / "columns"; }

}  // namespace tessera
