// A surface's triangles on their way to a file: a 2D result with the heights as first attribute, of the tiles of the
// triangulation that they come from.
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

class TriangleStore {
 public:
  // Of the result with this manifest; or of triangles that are to be written once more.
  TriangleStore(std::filesystem::path folder, const Manifest& from);

  const std::filesystem::path& folder() const { return folder_; }
  const Manifest& manifest() const { return manifest_; }
  // A tile, for several threads at once; one without triangles is left out.
  Status add(TileId tile, const StoredTile& triangles, const std::stop_token& stop);
  // One that was written there.
  void add(TileEntry entry);
  // When all have been added. `ids`: all ids are less. Error usage when there is no triangle.
  Status finish(std::uint64_t ids);

 private:
  std::filesystem::path folder_;
  Manifest manifest_;
  std::mutex mutex_;
};

// Each tile of a result to one of some threads, which is told its number.
struct TileWork {
  unsigned threads = 1;
  std::uint64_t memory_bytes = 0;
  std::stop_token stop = {};
};
Status for_each_tile(const TileSource& source, const TileParts& parts, const TileWork& how,
                     const std::function<Status(std::size_t index, StoredTile tile)>& work);

}  // namespace tessera::surface
