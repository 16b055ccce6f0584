// Holds the manifest of one version of a result. While the manifest is held, no writer removes the version's tiles.
//
// A reader holds a shared lock (flock) on the inode of the manifest that it has read. A writer replaces manifest.json
// by another file and keeps the old file under another name. A later writer tries to take the exclusive lock of the old
// inode: the writer gets the lock only when no reader uses that version any more (src/result/new_version.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::result {

struct HeldManifest {
  Manifest manifest;
  FileHandle file;  // open file of the manifest; carries the lock, where the file system has locks
};

// Holds the newest version. Errors: those of read_manifest(); io when writers replace the manifest again and again.
Result<HeldManifest> hold_manifest(const std::filesystem::path& out);
// Holds the version with this number. Error usage, with the versions that can be read, when this one cannot.
Result<HeldManifest> hold_version(const std::filesystem::path& out, std::uint32_t version);

// The numbers of the versions whose manifests exist, in ascending order. `newest`: the number of the current version.
Result<std::vector<std::uint32_t>> readable_versions(const std::filesystem::path& out, std::uint32_t newest);

}  // namespace tessera::result
