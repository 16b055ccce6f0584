// The new result of a change: files of the tiles that have changed, the files of the others as they are, and the
// manifest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/delaunay/update/changed_columns.h"
#include "src/delaunay/update/changed_tile.h"
#include "src/delaunay/update/update.h"
#include "src/delaunay/update/update_plan.h"
#include "src/result/new_version.h"
#include "src/result/store/duplicate_rows.h"
#include "src/tiling/partition.h"

namespace tessera {

class UpdatedResult {
 public:
  using Ends = std::map<TileId, TileEnd>;
  // What the change is made of.
  struct Made {
    const TileSource& whole;   // the result with its columns
    const TileSource& source;  // without
    const UpdatePlan& plan;
    const Ends& ends;  // what the tiles have become that the change has concerned
    const Partition& partition;
    std::uint64_t tile_points;  // a tile with more is too large
    const ResultChange& change;
    const UpdateOptions& options;
  };
  // `folder`: has the files of the tiles that have changed. `columns`: a folder for files with columns, if the result
  // has any. What `made` refers to outlives this object.
  UpdatedResult(const Made& made, std::filesystem::path folder, std::filesystem::path columns, std::stop_token stop)
      : whole_(made.whole),
        source_(made.source),
        plan_(made.plan),
        ends_(made.ends),
        partition_(made.partition),
        tile_points_(made.tile_points),
        change_(made.change),
        options_(made.options),
        folder_(std::move(folder)),
        columns_(std::move(columns)),
        stop_(std::move(stop)) {}

  // Makes target() a whole result: first links of the other tiles' files, then what belongs to no tile, the manifest
  // last.
  Status link_others();
  Status finish();
  // Instead of both: makes what was written the new version of the result. `before`: see NewVersion::commit().
  // REQUIRES: `folder` is in the same file system.
  Status commit(NewVersion& version, const std::function<Status(const std::string& manifest)>& before);
  const Manifest& manifest() const { return manifest_; }
  const std::filesystem::path& target() const { return whole_.manifest().columns.empty() ? folder_ : columns_; }

 private:
  // Whether the tile has another file now, or none.
  bool is_other(TileId tile) const;
  Result<Bounds> bounds() const;
  void describe(Manifest& manifest) const;
  std::vector<Manifest::Input> inputs() const;
  bool duplicates_changed() const;
  std::vector<DuplicatePair> duplicates() const;
  Status sort_rows(std::span<const DuplicatePair> duplicates, std::optional<DuplicateRowSort>& rows) const;
  Result<FinishedTiles> finished_tiles(std::span<const DuplicatePair> duplicates) const;

  const TileSource& whole_;
  const TileSource& source_;
  const UpdatePlan& plan_;
  const Ends& ends_;
  const Partition& partition_;
  std::uint64_t tile_points_;
  const ResultChange& change_;
  const UpdateOptions& options_;
  std::filesystem::path folder_, columns_;
  std::stop_token stop_;
  bool hull_changed_ = false;  // of the tiles that link_others() has finished
  Manifest manifest_;
};

}  // namespace tessera
