// What every tile knows of the others before any message has arrived: where they are, which of them touch it, and the
// seeds. Seeds are a few points of the whole cloud, known finely near a tile and coarsely far away. Each seed has a
// reach, and every tile whose points come within its reach has the seed. So a tile can tell which other tiles have a
// seed, and never sends it to them. All of it follows from the plan alone, so it is the same on every node.
//
// In a periodic cloud tiles may be images (src/base/image.h): what an image of a tile knows is what the tile knows,
// shifted. A tile has each image of a seed that reaches it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/ids.h"
#include "src/base/image.h"
#include "src/base/point.h"

namespace tessera {

// In SharedPoint::told while a stored result is changed: the point is fresh (docs/updates-design.md).
inline constexpr std::uint32_t fresh_bit = std::uint32_t{1} << 31;

class KnownFromStart {
 public:
  KnownFromStart() = default;
  // `bounds`: by tile, the bounds of its points. `neighbours`: by tile, the tiles, or images of tiles, that it
  // announces points to; ascending. In a periodic cloud points and bounds lie between 0 and the period.
  KnownFromStart(std::vector<Bounds> bounds, const std::vector<std::vector<TileId>>& neighbours,
                 std::vector<Seed> seeds, const Period& period = {});
  // The same, sharing the arrays of a plan that is in memory already.
  KnownFromStart(std::shared_ptr<const std::vector<Bounds>> bounds, const std::vector<std::vector<TileId>>& neighbours,
                 std::shared_ptr<const std::vector<Seed>> seeds, const Period& period = {});

  std::size_t tiles() const { return bounds_->size(); }
  bool periodic() const { return periodic_; }
  const Period& period() const { return period_; }
  // Whether there is such a tile, or image of a tile.
  bool has_tile(TileId tile) const {
    return plain(tile).value < tiles() && offset_code(tile) < image::codes && period_.allows(offset_of(tile));
  }
  // The bounds of a tile, or of an image of a tile.
  Bounds bounds(TileId tile) const;
  // REQUIRES: `tile` is no image.
  std::span<const TileId> neighbours(TileId tile) const {
    const std::uint32_t begin = tile.value == 0 ? 0 : neighbours_end_[tile.value - 1];
    return std::span(neighbours_).subspan(begin, neighbours_end_[tile.value] - begin);
  }
  // Returns a bit for SharedPoint::told: each of the first 32 neighbours of `owner` has one; for other tiles the result
  // is 0. The bit of two images is that of the two images that lie as far away.
  std::uint32_t bit(TileId owner, TileId neighbour) const;
  // From now on bit() leaves out the fresh bit, so only 31 neighbours have a bit.
  void leave_out_fresh_bit() { told_bits_ = 31; }

  // Whether a tile has a seed. The answer depends on the two alone, and is the same in every process, bit for bit.
  bool has(TileId tile, const Seed& seed) const {
    return (!periodic_ || (offset_of(seed.point.tile) - offset_of(tile)).near()) && reaches(seed, bounds(tile));
  }
  // Returns the seeds that a tile has, its own points included. REQUIRES: `tile` is no image.
  std::vector<Seed> seeds_of(TileId tile) const;
  const std::vector<Seed>& seeds() const { return *seeds_; }

 private:
  struct Block {  // of consecutive seeds
    Bounds bounds;
    double reach = 0;  // the largest reach of these seeds
  };
  static bool reaches(const Seed& seed, const Bounds& bounds);
  void collect(std::size_t block, const Bounds& bounds, std::vector<Seed>& out) const;

  // Every node has the bounds of all tiles, however few of the tiles are its own.
  std::shared_ptr<const std::vector<Bounds>> bounds_ = std::make_shared<const std::vector<Bounds>>();
  std::vector<TileId> neighbours_;             // one tile after the other
  std::vector<std::uint32_t> neighbours_end_;  // by tile: where its neighbours end
  std::shared_ptr<const std::vector<Seed>> seeds_ = std::make_shared<const std::vector<Seed>>();
  std::vector<Block> blocks_;  // a complete binary tree in an array: [1] is the root
  std::size_t told_bits_ = 32;
  Period period_;
  bool periodic_ = false;
};

}  // namespace tessera
