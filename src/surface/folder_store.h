// Keeps tiles, and what steps leave of them, for the programs of a surface's steps: in the job's run folder, which all
// nodes see, and in memory and files of this node.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "src/delaunay/run/result_stages.h"
#include "src/surface/step_store.h"
#include "src/surface/working_tiles.h"

namespace tessera::surface {

class FolderStore final : public StepStore {
 public:
  // Makes the folders.
  static Result<std::unique_ptr<FolderStore>> open(const ResultInput& input);

  Result<std::unique_ptr<SurfaceTile>> take(TileId tile) override;
  Status give_back(std::unique_ptr<SurfaceTile> tile) override;
  Status write(StepOutput what, TileId tile, std::span<const std::byte> bytes) override;
  Result<Bytes> read(StepOutput what, TileId tile) override;
  Result<Bytes> keep_triangles(TileId tile, const StoredTile& triangles) override;

 private:
  explicit FolderStore(const ResultInput& input);
  Result<std::size_t> place_of(TileId tile) const;

  std::filesystem::path run_;
  std::uint64_t seal_;
  NodeId node_;
  std::stop_token stop_;
  WorkingTiles tiles_;
};

// Reads what was kept of a tile in a run, to finish the surface. Errors: io, corrupt.
Result<Bytes> read_kept(const std::filesystem::path& run, std::uint64_t seal, StepOutput what, TileId tile);
// Returns the tiles of which `what` was kept.
Result<std::vector<TileId>> tiles_kept(const std::filesystem::path& run, StepOutput what);

}  // namespace tessera::surface
