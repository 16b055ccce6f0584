#include "src/tiling/tile/known_from_start.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "src/base/ieee_arithmetic.h"

namespace tessera {
namespace {

constexpr std::size_t block_seeds = 8;

// The result is rounded in the same way for every caller, so that all processes agree.
double squared_gap(const Bounds& a, const Bounds& b) {
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const double gap = std::max({a.lo[i] - b.hi[i], b.lo[i] - a.hi[i], 0.0});
    squared += gap * gap;
  }
  return squared;
}

}  // namespace

KnownFromStart::KnownFromStart(std::vector<Bounds> bounds, const std::vector<std::vector<TileId>>& neighbours,
                               std::vector<Seed> seeds)
    : KnownFromStart(std::make_shared<const std::vector<Bounds>>(std::move(bounds)), neighbours,
                     std::make_shared<const std::vector<Seed>>(std::move(seeds))) {}

KnownFromStart::KnownFromStart(std::shared_ptr<const std::vector<Bounds>> bounds,
                               const std::vector<std::vector<TileId>>& neighbours,
                               std::shared_ptr<const std::vector<Seed>> seeds)
    : bounds_(std::move(bounds)), seeds_(std::move(seeds)) {
  std::size_t all = 0;
  for (const auto& list : neighbours) all += list.size();
  neighbours_.reserve(all);
  neighbours_end_.reserve(neighbours.size());
  for (const auto& list : neighbours) {
    neighbours_.insert(neighbours_.end(), list.begin(), list.end());
    neighbours_end_.push_back(static_cast<std::uint32_t>(neighbours_.size()));
  }
  const std::size_t leaves = std::bit_ceil((seeds_->size() + block_seeds - 1) / block_seeds);
  blocks_.resize(2 * leaves);
  for (std::size_t i = 0; i < seeds_->size(); ++i) {
    const Seed& seed = (*seeds_)[i];
    Block& block = blocks_[leaves + i / block_seeds];
    block.bounds.add(seed.point.at);
    block.reach = std::max(block.reach, seed.reach);
  }
  for (std::size_t b = leaves - 1; b > 0; --b) {
    blocks_[b] = blocks_[2 * b];
    blocks_[b].bounds.add(blocks_[2 * b + 1].bounds);
    blocks_[b].reach = std::max(blocks_[b].reach, blocks_[2 * b + 1].reach);
  }
}

std::uint32_t KnownFromStart::bit(TileId owner, TileId neighbour) const {
  const auto list = neighbours(owner);
  const auto end = list.begin() + static_cast<std::ptrdiff_t>(std::min(told_bits_, list.size()));
  const auto found = std::find(list.begin(), end, neighbour);
  return found == end ? 0 : std::uint32_t{1} << (found - list.begin());
}

bool KnownFromStart::reaches(const Seed& seed, const Bounds& bounds) {
  if (bounds.empty()) return false;
  return squared_gap({seed.point.at, seed.point.at}, bounds) <= seed.reach * seed.reach;
}

std::vector<Seed> KnownFromStart::seeds_of(TileId tile) const {
  std::vector<Seed> out;
  if (!seeds_->empty()) collect(1, tile, out);
  return out;
}

// Skips a block when none of its seeds can reach the tile: the gap of the block is not larger than theirs, and rounding
// preserves that.
void KnownFromStart::collect(std::size_t block, TileId tile, std::vector<Seed>& out) const {
  const Block& b = blocks_[block];
  if (b.bounds.empty() || squared_gap(b.bounds, bounds(tile)) > b.reach * b.reach) return;
  const std::size_t leaves = blocks_.size() / 2;
  if (block < leaves) {
    collect(2 * block, tile, out);
    collect(2 * block + 1, tile, out);
    return;
  }
  const std::size_t begin = (block - leaves) * block_seeds, end = std::min(seeds_->size(), begin + block_seeds);
  for (std::size_t i = begin; i < end; ++i) {
    if (has(tile, (*seeds_)[i])) out.push_back((*seeds_)[i]);
  }
}

}  // namespace tessera
