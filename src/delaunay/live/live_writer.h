// Writes tiles of a live result, as files of a result.
#pragma once

#include <cstddef>
#include <filesystem>
#include <set>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/live/live_rows.h"
#include "src/delaunay/live/live_version.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"

namespace tessera {

class LiveWriter {
 public:
  // `source`: what is stored of older points, with their attributes, in tiles of the partition `stored`. `rows`: the
  // attributes of the others. All outlive this object.
  LiveWriter(const TileSource& source, const Partition& stored, const LiveVersion& version, const LiveRows& rows)
      : source_(source), stored_(stored), version_(version), rows_(rows), stored_rows_(source) {}

  // Writes those of these tiles that have points. Errors: those of writing, and of reading the source.
  Result<std::vector<TileEntry>> write(const std::set<TileId>& tiles, const std::filesystem::path& folder,
                                       unsigned threads);

 private:
  Result<TileEntry> write_one(TileId tile, const std::filesystem::path& folder);
  Result<std::vector<std::byte>> rows_of(const TileMesh& mesh, TileId home);

  const TileSource& source_;
  const Partition& stored_;
  const LiveVersion& version_;
  const LiveRows& rows_;
  StoredRows stored_rows_;
};

}  // namespace tessera
