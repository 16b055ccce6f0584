// Messages between Delaunay tiles, which are lists of points: those that have come and are not inserted yet, and those
// that a tile sends.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/exchange/tile_program.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

// Not thread-safe.
class HeardPoints {
 public:
  // Takes the points of a message. Of their told bits only those in `believed` stay. Error internal when the message is
  // no list of points.
  Status add(TileId self, TileId from, const Message& message, std::uint32_t believed);
  bool empty() const { return heard_.empty(); }
  std::size_t memory() const { return heard_.capacity() * sizeof(Heard); }
  // Gives all points to the triangulation, and forgets them.
  Status insert_into(TileTriangulation& triangulation, int dimension);

 private:
  struct Heard {
    TileId from;
    SharedPoint point;
  };
  std::vector<Heard> heard_;
};

// Returns what the tile must now send, and makes it forget that.
std::vector<std::pair<TileId, Message>> messages_of(TileTriangulation& triangulation);

}  // namespace tessera
