// Reads the tiles of a result that is changed, and keeps what becomes of them in the run folder of the change.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "src/delaunay/run/result_stages.h"
#include "src/delaunay/update/rows_of_tiles.h"
#include "src/delaunay/update/update_store.h"
#include "src/result/tile_source.h"

namespace tessera {

class UpdateFolder final : public UpdateStore {
 public:
  // `writes`: whether tiles that have changed are written; else it is only noted that they have.
  UpdateFolder(const ResultInput& input, std::shared_ptr<const UpdatePlan> plan, bool writes);

  Result<TileMesh> read(TileId tile, bool cells) override;
  Status keep_told(TileId tile, const ToldOfHoles& told) override;
  Result<ToldOfHoles> told(TileId tile) override;
  Status store(TileId tile, TileEnd end, CollectedTile* cells) override;

 private:
  Result<TileEntry> write(TileId tile, CollectedTile& cells);

  TileSource source_;
  std::filesystem::path run_;
  std::uint64_t seal_;
  NodeId node_;
  std::stop_token stop_;
  RowsOfTiles rows_;
  bool writes_, many_nodes_;
};

// Returns what has become of a tile in a run with this seal. Errors: io, corrupt.
Result<TileEnd> read_end(const std::filesystem::path& run, std::uint64_t seal, TileId tile);
// Returns the tiles of which a folder of the run has a file.
Result<std::vector<TileId>> tiles_in(const std::filesystem::path& folder);

}  // namespace tessera
