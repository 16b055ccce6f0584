// What every tile knows of the others before it has heard anything: where they are, which of them touch, and the seeds:
// a few points of the whole cloud, known finely near a tile and coarsely far away. Each seed reaches some way around
// itself, and every tile whose points come within its reach has it: so a tile can tell who has which, and never sends
// them. Made from the plan alone, the same on every node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"

namespace tessera {

class KnownFromStart {
 public:
  KnownFromStart() = default;
  // `bounds`: by tile, of its points. `neighbours`: by tile, whom it tells first; ascending.
  KnownFromStart(std::vector<Bounds> bounds, const std::vector<std::vector<TileId>>& neighbours,
                 std::vector<Seed> seeds);
  // The same, of a plan that is in memory already.
  KnownFromStart(std::shared_ptr<const std::vector<Bounds>> bounds, const std::vector<std::vector<TileId>>& neighbours,
                 std::shared_ptr<const std::vector<Seed>> seeds);

  std::size_t tiles() const { return bounds_->size(); }
  const Bounds& bounds(TileId tile) const { return (*bounds_)[tile.value]; }
  std::span<const TileId> neighbours(TileId tile) const {
    const std::uint32_t begin = tile.value == 0 ? 0 : neighbours_end_[tile.value - 1];
    return std::span(neighbours_).subspan(begin, neighbours_end_[tile.value] - begin);
  }
  // For SharedPoint::told: a bit for each of the first 32 neighbours of a tile, and none for any other tile.
  std::uint32_t bit(TileId owner, TileId neighbour) const;

  // Whether a tile has a seed. A function of the two alone, bit for bit, whoever asks.
  bool has(TileId tile, const Seed& seed) const { return reaches(seed, bounds(tile)); }
  // Those that a tile has, its own among them.
  std::vector<Seed> seeds_of(TileId tile) const;
  const std::vector<Seed>& seeds() const { return *seeds_; }

 private:
  struct Block {  // of consecutive seeds
    Bounds bounds;
    double reach = 0;  // the largest
  };
  static bool reaches(const Seed& seed, const Bounds& bounds);
  void collect(std::size_t block, TileId tile, std::vector<Seed>& out) const;

  // Every node has all of it, however few of the tiles are its own.
  std::shared_ptr<const std::vector<Bounds>> bounds_ = std::make_shared<const std::vector<Bounds>>();
  std::vector<TileId> neighbours_;             // of one tile after the other
  std::vector<std::uint32_t> neighbours_end_;  // by tile
  std::shared_ptr<const std::vector<Seed>> seeds_ = std::make_shared<const std::vector<Seed>>();
  std::vector<Block> blocks_;  // a complete binary tree in rows: [1] is the root
};

}  // namespace tessera
