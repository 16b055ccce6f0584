// Stores a surface's triangles as a 2D result with the heights as first attribute. Its tiles are those of the
// triangulation that the triangles come from.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <mutex>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera::surface {

// Collects the tiles of such a result, and writes its manifest.
class TriangleStore {
 public:
  // `from`: the manifest of the triangulation, or of triangles that are written again.
  TriangleStore(std::filesystem::path folder, const Manifest& from);

  const std::filesystem::path& folder() const { return folder_; }
  const Manifest& manifest() const { return manifest_; }
  // Writes a tile; a tile without triangles is left out. Thread-safe.
  Status add(TileId tile, const StoredTile& triangles, const std::stop_token& stop);
  // Adds a tile that was written to the folder before.
  void add(TileEntry entry);
  // Completes the result, when all tiles have been added. `ids`: all ids are less. Error usage when there is no
  // triangle.
  Status finish(std::uint64_t ids);

 private:
  std::filesystem::path folder_;
  Manifest manifest_;
  std::mutex mutex_;
};

// How for_each_tile() works: it gives each tile of a result, with its index, to one of some threads.
struct TileWork {
  unsigned threads = 1;
  std::uint64_t memory_bytes = 0;
  std::stop_token stop = {};
};
Status for_each_tile(const TileSource& source, const TileFields& parts, const TileWork& how,
                     const std::function<Status(std::size_t index, StoredTile tile)>& work);

}  // namespace tessera::surface
