// Writes tiles of a live result, as files of a result.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/live/live_version.h"
#include "src/result/tile_source.h"

namespace tessera {

class LiveWriter {
 public:
  using Rows = std::map<PointId, std::vector<std::byte>>;
  // `source`: what is stored of older points, with their attributes. `rows`: the attributes of the others. All outlive
  // this object.
  LiveWriter(const TileSource& source, const LiveVersion& version, const Rows& rows)
      : source_(source), version_(version), rows_(rows) {}

  // Writes those of these tiles that have points. Errors: those of writing, and of reading the source.
  Result<std::vector<TileEntry>> write(const std::set<TileId>& tiles, const std::filesystem::path& folder,
                                       unsigned threads);

 private:
  Result<TileEntry> write_one(TileId tile, const std::filesystem::path& folder);
  Result<std::vector<std::byte>> rows_of(TileId tile, const TileMesh& mesh);
  // The stored attributes of the vertices of a tile.
  Result<const Rows*> stored_rows(TileId tile);

  const TileSource& source_;
  const LiveVersion& version_;
  const Rows& rows_;
  std::mutex mutex_;
  std::map<TileId, Rows> stored_;  // that were read so far
};

}  // namespace tessera
