// The folder of a changed result: files of the tiles that have changed, links to the others, and the manifest.
#pragma once

#include <filesystem>
#include <map>
#include <utility>

#include "src/base/result.h"
#include "src/delaunay/update/changed_tile.h"
#include "src/delaunay/update/update.h"
#include "src/delaunay/update/update_plan.h"
#include "src/result/tile_source.h"

namespace tessera {

class UpdatedResult {
 public:
  using Ends = std::map<TileId, TileEnd>;
  // `ends`: what the tiles have become that the change has concerned. `folder`: has the files of the tiles that have
  // changed. All arguments outlive this object.
  UpdatedResult(const TileSource& source, const UpdatePlan& plan, const Ends& ends, std::filesystem::path folder)
      : source_(source), plan_(plan), ends_(ends), folder_(std::move(folder)) {}

  Status link_others();
  // Writes what belongs to no tile, the manifest last.
  Status finish(const ResultChange& change, const UpdateOptions& options);
  const Manifest& manifest() const { return manifest_; }

 private:
  // Whether the tile has another file now, or none.
  bool is_other(TileId tile) const;
  Result<Bounds> bounds() const;

  const TileSource& source_;
  const UpdatePlan& plan_;
  const Ends& ends_;
  std::filesystem::path folder_;
  Manifest manifest_;
};

}  // namespace tessera
