// Where the tiles of a result that is changed are read, and what is kept of them.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/delaunay/update/changed_tile.h"
#include "src/delaunay/update/update_plan.h"
#include "src/tiling/tile/collected_tile.h"
#include "src/tiling/tile/known_from_start.h"

namespace tessera {

// Thread-safe for different tiles.
class UpdateStore {
 public:
  virtual ~UpdateStore() = default;
  // Returns a tile as the result has it; a tile without points for one that the result does not have.
  virtual Result<TileMesh> read(TileId tile, bool cells) = 0;

  // Keeps what a tile was told of holes, where all nodes find it. Written once, or again with the same content.
  virtual Status keep_told(TileId tile, const ToldOfHoles& told) = 0;
  // Returns what was kept; nothing was told if nothing was kept.
  virtual Result<ToldOfHoles> told(TileId tile) = 0;
  // Keeps what a tile has become. `cells`: of a tile that has changed and has points; null for others.
  virtual Status store(TileId tile, TileEnd end, CollectedTile* cells) = 0;
};

// What all tiles of a change have in common on a node. Read-only.
struct UpdateSetting {
  int dimension = 3;
  std::shared_ptr<const UpdatePlan> plan;
  // By tile of the partition. The bounds of tiles that take no part are empty.
  std::shared_ptr<const KnownFromStart> around;
  std::shared_ptr<UpdateStore> store;
  std::string result;  // its folder, for errors
  std::stop_token stop = {};
};

}  // namespace tessera
