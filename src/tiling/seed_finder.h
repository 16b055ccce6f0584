// Chooses the seeds: which points of a cloud tiles know from the start, and how far each is known. The choice is made
// while points are routed, and depends on the partition and the cloud alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/flat_codec.h"
#include "src/base/image.h"
#include "src/base/point.h"
#include "src/tiling/partition.h"

namespace tessera {

// Every subtree of the split tree, from one tile up to the whole cloud, has a point that represents it, drawn by
// a hash of the coordinates. Where the subtree's box is unbounded, it also has its outermost points. What represents a
// subtree also represents each of its halves that contains the point, so the seeds of the whole cloud are among the
// seeds of its subtrees. The reach of a seed comes from the largest subtree that it represents: it is proportional to
// the size of the subtree around that subtree. So a tile knows its surroundings finely and the distant world coarsely.
// With a balanced tree of k tiles a tile has O(log k) seeds.
//
// A periodic cloud has no outermost points along an axis with a period.
class SeedFinder {
 public:
  explicit SeedFinder(int dimension, const Period& period = {}) : dimension_(dimension), period_(period) {}

  // Adds a point of `tile`, whose box is `box`. REQUIRES: ids ascend.
  void add(TileId tile, const Box& box, const LocalPoint& p);
  // Adds points with higher ids, which another finder has seen. `first_id` is to be added to their ids.
  void add(const SeedFinder& next, std::uint64_t first_id);
  // Forgets the points of a tile.
  void restart(TileId tile);
  void write(FlatWriter& to) const;
  // Returns false when the bytes are not what write() makes of at most `tiles` tiles.
  bool read(FlatReader& from, std::uint32_t tiles);

  // Returns the seeds by tile, and by id within a tile. `bounds`: by tile, the bounds of its points. `everywhere`:
  // points that all tiles know in any case.
  std::vector<Seed> choose(const Partition& partition, const std::vector<Bounds>& bounds,
                           std::span<const LocalPoint> everywhere) const;

 private:
  struct Candidate {
    double key = 0;  // the candidate with the greatest key wins
    LocalPoint point;
  };
  struct Outermost {
    int direction = 0;
    Candidate best;
  };
  struct Subtree {
    bool empty = true;
    Candidate drawn;
    std::vector<Outermost> outermost;  // in the directions in which the subtree is unbounded
    Bounds bounds;
    Box box;
  };
  Subtree merged(const Subtree& a, const Subtree& b) const;

  // Whether the cloud has outermost points of the box in this direction.
  bool endless(const Box& box, int direction) const;

  int dimension_;
  Period period_;
  std::vector<Subtree> tiles_;
};

}  // namespace tessera
