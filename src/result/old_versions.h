// Finds older versions of a result.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::result {

// A manifest that a newer manifest has replaced.
struct OldVersion {
  std::uint32_t version = 0;
  std::filesystem::path file;
  bool copy = false;  // a copy of the manifest, not a second name of its inode: so its readers cannot be found
};

// Returns the old versions, in ascending order. The list includes leftovers of a killed writer, which have the number
// of the current version or a higher number. Error io.
Result<std::vector<OldVersion>> old_versions(const std::filesystem::path& out);

// The names of the manifest's tile files, without their folder.
std::set<std::filesystem::path> tile_names(const Manifest& manifest);

}  // namespace tessera::result
