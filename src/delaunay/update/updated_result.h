// The folder of a changed result: files of the tiles that have changed, links to the others, and the manifest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/update/changed_columns.h"
#include "src/delaunay/update/update.h"
#include "src/delaunay/update/woken_tile.h"
#include "src/result/new_version.h"
#include "src/result/store/duplicate_rows.h"

namespace tessera {

class UpdatedResult {
 public:
  using Tiles = std::map<TileId, std::unique_ptr<WokenTile>>;
  // `tiles`: those that were read, after the exchange. `folder`: empty.
  UpdatedResult(const UpdateSetting& setting, Tiles& tiles, std::filesystem::path folder)
      : setting_(setting), tiles_(tiles), folder_(std::move(folder)) {}

  // Writes the tiles that have changed. REQUIRES: none of them is flat.
  Status write_changed(unsigned threads);
  Status link_others();
  // Writes what belongs to no tile, the manifest last.
  Status finish(const ResultChange& change, const UpdateOptions& options);
  // Instead of the last two: makes what was written the new version of the result. REQUIRES: `folder` is the scratch
  // folder of the version.
  Status commit(NewVersion& version, const ResultChange& change, const UpdateOptions& options);
  const Manifest& manifest() const { return manifest_; }

 private:
  Status write(TileId tile, WokenTile& woken);
  Result<std::vector<std::byte>> rows_of(const TileMesh& mesh, TileId tile) const;
  Result<TileEntry> write_as_points(TileId tile, const TileMesh& mesh, const std::vector<std::byte>& rows);
  bool is_gone(TileId tile) const;
  Result<Bounds> bounds() const;
  void describe(Manifest& manifest, const ResultChange& change, const UpdateOptions& options) const;
  std::vector<DuplicatePair> duplicates() const;
  Result<std::vector<FinishedTile>> finished_tiles(const NewVersion& version, unsigned threads) const;
  bool duplicates_changed() const;
  Status sort_rows(std::span<const DuplicatePair> duplicates, std::span<const std::byte> added,
                   std::optional<DuplicateRowSort>& rows) const;
  TileKind kind_of(TileId tile) const;

  const UpdateSetting& setting_;
  Tiles& tiles_;
  std::filesystem::path folder_;
  std::mutex mutex_;
  std::map<TileId, TileEntry> written_;
  Bounds written_bounds_;  // of the own vertices of the tiles that were written
  Manifest manifest_;
};

}  // namespace tessera
