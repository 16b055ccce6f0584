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
                               std::vector<Seed> seeds, const Period& period)
    : KnownFromStart(std::make_shared<const std::vector<Bounds>>(std::move(bounds)), neighbours,
                     std::make_shared<const std::vector<Seed>>(std::move(seeds)), period) {}

KnownFromStart::KnownFromStart(std::shared_ptr<const std::vector<Bounds>> bounds,
                               const std::vector<std::vector<TileId>>& neighbours,
                               std::shared_ptr<const std::vector<Seed>> seeds, const Period& period)
    : bounds_(std::move(bounds)), seeds_(std::move(seeds)), period_(period), periodic_(period.any()) {
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

Bounds KnownFromStart::bounds(TileId tile) const {
  const Bounds& at = (*bounds_)[plain(tile).value];
  if (offset_code(tile) == 0) return at;
  const PeriodOffset o = offset_of(tile);
  return {period_.shifted(at.lo, o), period_.shifted(at.hi, o)};
}

std::uint32_t KnownFromStart::bit(TileId owner, TileId neighbour) const {
  if (periodic_ && offset_code(owner) != 0) {
    const PeriodOffset apart = offset_of(neighbour) - offset_of(owner);
    if (!apart.near()) return 0;
    owner = plain(owner);
    neighbour = image_of(neighbour, apart);
  }
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
  if (seeds_->empty()) return out;
  if (!periodic_) {
    collect(1, bounds(tile), out);
    return out;
  }
  // Where an image reaches the tile, the seed itself reaches the opposite image of the tile. No coordinate is rounded,
  // so both gaps are the same.
  for (const PeriodOffset& o : period_.offsets()) {
    const std::size_t first = out.size();
    collect(1, bounds(image_of(tile, PeriodOffset{} - o)), out);
    for (std::size_t i = first; i < out.size(); ++i) {
      SharedPoint& p = out[i].point;
      p = {period_.shifted(p.at, o), image_of(p.id, o), image_of(p.tile, o), p.told};
    }
  }
  return out;
}

// Skips a block when none of its seeds can reach the tile: the gap of the block is not larger than theirs, and rounding
// preserves that.
void KnownFromStart::collect(std::size_t block, const Bounds& bounds, std::vector<Seed>& out) const {
  const Block& b = blocks_[block];
  if (b.bounds.empty() || squared_gap(b.bounds, bounds) > b.reach * b.reach) return;
  const std::size_t leaves = blocks_.size() / 2;
  if (block < leaves) {
    collect(2 * block, bounds, out);
    collect(2 * block + 1, bounds, out);
    return;
  }
  const std::size_t begin = (block - leaves) * block_seeds, end = std::min(seeds_->size(), begin + block_seeds);
  for (std::size_t i = begin; i < end; ++i) {
    if (reaches((*seeds_)[i], bounds)) out.push_back((*seeds_)[i]);
  }
}

}  // namespace tessera
