// What is left of older versions of a result.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::result {

// A manifest that a newer one has replaced.
struct OldVersion {
  std::uint32_t version = 0;
  std::filesystem::path file;
  bool copy = false;  // of the manifest: nobody can tell who reads that version
};

// By version; with leftovers of a writer that was killed, which are of the version that stands, or of later ones.
// Error io.
Result<std::vector<OldVersion>> old_versions(const std::filesystem::path& out);

// The names of its tile files, without their folder.
std::set<std::filesystem::path> tile_names(const Manifest& manifest);

}  // namespace tessera::result
