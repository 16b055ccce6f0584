// Splits tiles of a live result that have grown too large, when its newest version is stored (grown_tiles.h splits
// those of a stored result). All tiles keep their cells: a part has the own points of the tile on one side, and the
// vertices with which they share a cell. Tiles that know points of a split tile are copied, with other owners of these
// points. So readers of the version before are not disturbed, and a split that is not stored has changed nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>

#include "src/base/result.h"
#include "src/delaunay/live/live_version.h"
#include "src/tiling/partition.h"
#include "src/tiling/tile/known_from_start.h"

namespace tessera {

struct LiveSplit {
  std::shared_ptr<const Partition> partition;
  LiveVersion::Tiles tiles;
  // The tiles whose files will be others because of the split: the parts, and those that have cells with vertices of
  // split tiles.
  std::set<TileId> concerned;
};

// Splits those of the tiles `changed` that have more than `limit` own points. Nothing when there are none, or when they
// cannot be split. `around` outlives the tiles, and need not have the new tiles yet. Errors: memory when a kernel
// cannot number the points of a part; corrupt.
Result<std::optional<LiveSplit>> split_grown(const LiveVersion& version, const std::set<TileId>& changed,
                                             std::uint64_t limit, const KnownFromStart& around);

}  // namespace tessera
