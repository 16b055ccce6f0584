// Which points of a cloud tiles know from the start, and how far each of them is known. Chosen while points are routed,
// and a function of the partition and the cloud alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/flat_codec.h"
#include "src/base/point.h"
#include "src/tiling/partition.h"

namespace tessera {

// Every part of the split tree, a tile or larger, has a point drawn from a hash of its coordinates, and, where it has
// no end, the outermost points. What represents a part represents those of its halves that it lies in, too: so the
// seeds of the whole cloud are among those of its parts. A point is known as far as the largest part it represents asks
// for: in proportion to the size of the part around that one. So a tile knows its surroundings finely and the far world
// coarsely; with a balanced tree of k tiles it has O(log k) seeds.
class SeedFinder {
 public:
  explicit SeedFinder(int dimension) : dimension_(dimension) {}

  // A point of a tile; by ascending id. `box`: of the tile.
  void add(TileId tile, const Box& box, const LocalPoint& p);
  // Points with higher ids, which are `first_id` more than they say.
  void add(const SeedFinder& next, std::uint64_t first_id);
  // Forgets what a tile had.
  void restart(TileId tile);
  void write(FlatWriter& to) const;
  // False when it is not what write() gives of so many tiles.
  bool read(FlatReader& from, std::uint32_t tiles);

  // By tile, and by id within. `bounds`: by tile, of its points. `everywhere`: known to all tiles in any case.
  std::vector<Seed> choose(const Partition& partition, const std::vector<Bounds>& bounds,
                           std::span<const LocalPoint> everywhere) const;

 private:
  struct Candidate {
    double key = 0;  // the greatest wins
    LocalPoint point;
  };
  struct Outermost {
    int direction = 0;
    Candidate best;
  };
  struct Part {
    bool empty = true;
    Candidate drawn;
    std::vector<Outermost> outermost;  // in the directions in which it has no end
    Bounds bounds;
    Box box;
  };
  Part merged(const Part& a, const Part& b) const;

  int dimension_;
  std::vector<Part> tiles_;
};

}  // namespace tessera
