// The manifest of a version of a result, held against removal while somebody reads its tiles.
//
// A reader holds a shared lock (flock) on the inode of the manifest that it has read. A writer replaces manifest.json
// by another file and keeps the old one under another name, so that a later writer can try to lock that inode for
// itself: it succeeds when nobody reads the version any more (src/result/new_version.h).
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::result {

struct HeldManifest {
  Manifest manifest;
  FileHandle file;  // with the lock, where the file system has locks
};

// The newest version. Errors: those of read_manifest(); io when writers replace the manifest again and again.
Result<HeldManifest> hold_manifest(const std::filesystem::path& out);

}  // namespace tessera::result
