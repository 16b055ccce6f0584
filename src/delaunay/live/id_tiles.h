// Which tile owns the point of a source index. A point changes its tile only when the tile is split, and a removed
// index never comes again, so entries are only added. Versions of a live result share them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/ids.h"

namespace tessera {

// Immutable, and cheap to copy: a few sorted lists, each at most half as long as the one before.
class IdTiles {
 public:
  using Entry = std::pair<PointId, TileId>;
  // Returns the same with more entries, which need not be sorted. REQUIRES: none of the ids is there already.
  IdTiles with(std::vector<Entry> entries) const;
  // The tile of a point that is there or was removed.
  std::optional<TileId> find(PointId id) const;
  std::size_t size() const;  // with removed points
  std::size_t memory() const;

 private:
  struct List {
    std::vector<PointId> ids;
    std::vector<TileId> tiles;
  };
  std::vector<std::shared_ptr<const List>> lists_;
};

}  // namespace tessera
