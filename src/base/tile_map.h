// How the tiles of a job lie in space, and how far each tile is, for people who watch. Thread-safe.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"

namespace tessera {

// The state of a tile, as a letter of TileMap::stages(). No letter there is `settled`.
enum class TileStatus : char {
  empty = 'e',         // has no points and takes no part
  waiting = 'w',       // not triangulated yet
  triangulated = 't',  // triangulated by itself
  splayed = 's',       // has inserted points of other tiles; may have to again
  // no tile has anything to tell it any more; all tiles settle at once, so reached() is never called with it
  settled = 'q',
  stored = 'd'  // final and on disk
};

// A plane that cuts a part of space in two. Points with coordinate < `at` are below. A child >= 0 is a row of the cuts;
// a negative child is the tile -1-child. Row 0 is the root.
struct TileCut {
  double at = 0;
  std::int32_t axis = 0, below = 0, above = 0;
};

// How the tiles of a job lie in space.
struct TileLayout {
  int dimension = 3;
  Bounds bounds;              // of all points
  std::vector<TileCut> cuts;  // empty with a single tile, and for jobs whose tiles have no place in space
};

// The layout and the states of a job's tiles.
class TileMap {
 public:
  // Starts a run and forgets the run before. `tile_points` has the number of points of each tile.
  void begin(TileLayout layout, const std::vector<std::uint64_t>& tile_points);
  // Records that a tile has reached a state. A tile that is triangulated a second time counts in begun_again().
  void note_reached(TileId tile, TileStatus stage);

  TileLayout layout() const;
  // One letter for each tile. Empty before begin().
  std::string stages() const;
  // How many times a tile was triangulated again, after a node or its scratch was lost.
  std::uint64_t begun_again() const;

 private:
  mutable std::mutex mutex_;
  TileLayout layout_;
  std::string stages_;
  std::uint64_t begun_again_ = 0;
};

}  // namespace tessera
