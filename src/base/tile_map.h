// How the tiles of a job lie, and how far each of them is, for those who watch. Safe from any thread.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"

namespace tessera {

// As the letters of TileMap::stages(), of which none is `settled`.
enum class TileStage : char {
  empty = 'e',         // has no points, and takes no part
  waiting = 'w',       // not triangulated yet
  triangulated = 't',  // by itself
  splayed = 's',       // has taken in points of other tiles, and may have to again
  settled = 'q',       // nobody has anything to tell it any more: all tiles at once, so that reached() is not told
  stored = 'd'         // final, and on disk
};

// A plane that cuts a part of space in two: points with coordinate < `at` are below. A child >= 0 is a row of the cuts,
// a negative one is the tile -1-child; row 0 is the root.
struct TileCut {
  double at = 0;
  std::int32_t axis = 0, below = 0, above = 0;
};

struct TileLayout {
  int dimension = 3;
  Bounds bounds;              // of the points
  std::vector<TileCut> cuts;  // none with one tile, and where tiles have no place
};

class TileMap {
 public:
  // `tile_points`: by tile. What was known of another run is forgotten.
  void begin(TileLayout layout, const std::vector<std::uint64_t>& tile_points);
  // A tile that is triangulated again has lost what it was (begun_again()).
  void reached(TileId tile, TileStage stage);

  TileLayout layout() const;
  // A letter a tile; empty before begin().
  std::string stages() const;
  // How many times a tile was triangulated another time, after the loss of a node or of what was on scratch.
  std::uint64_t begun_again() const;

 private:
  mutable std::mutex mutex_;
  TileLayout layout_;
  std::string stages_;
  std::uint64_t begun_again_ = 0;
};

}  // namespace tessera
