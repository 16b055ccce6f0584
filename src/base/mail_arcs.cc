#include "src/base/mail_arcs.h"

#include <algorithm>
#include <queue>
#include <tuple>

namespace tessera {
namespace {

// Returns the number of tiles below each row.
std::vector<std::uint32_t> count_tiles(const std::vector<TileCut>& cuts) {
  std::vector<std::int32_t> order{0};  // parents first
  for (std::size_t i = 0; i < order.size(); ++i) {
    const TileCut& cut = cuts[static_cast<std::size_t>(order[i])];
    for (const std::int32_t child : {cut.below, cut.above}) {
      if (child >= 0) order.push_back(child);
    }
  }
  std::vector<std::uint32_t> tiles(cuts.size());
  for (auto row = order.rbegin(); row != order.rend(); ++row) {
    const auto r = static_cast<std::size_t>(*row);
    for (const std::int32_t child : {cuts[r].below, cuts[r].above})
      tiles[r] += child < 0 ? 1 : tiles[static_cast<std::size_t>(child)];
  }
  return tiles;
}

// Cuts the largest region in two as long as more regions are allowed.
std::vector<std::int32_t> cut_up(const std::vector<TileCut>& cuts, std::size_t max) {
  const std::vector<std::uint32_t> tiles = count_tiles(cuts);
  std::priority_queue<std::pair<std::uint32_t, std::int32_t>> rows;
  rows.emplace(tiles[0], 0);
  std::vector<std::int32_t> regions;
  while (!rows.empty() && rows.size() + regions.size() < max) {
    const TileCut& cut = cuts[static_cast<std::size_t>(rows.top().second)];
    rows.pop();
    for (const std::int32_t child : {cut.below, cut.above}) {
      if (child < 0) {
        regions.push_back(child);
      } else {
        rows.emplace(tiles[static_cast<std::size_t>(child)], child);
      }
    }
  }
  for (; !rows.empty(); rows.pop()) regions.push_back(rows.top().second);
  return regions;
}

}  // namespace

std::vector<MailArc> heaviest(std::vector<MailArc> arcs, std::size_t max) {
  const auto before = [](const MailArc& a, const MailArc& b) {
    return std::tuple(b.bytes, a.from, a.to) < std::tuple(a.bytes, b.from, b.to);
  };
  const auto end = arcs.begin() + static_cast<std::ptrdiff_t>(std::min(max, arcs.size()));
  std::partial_sort(arcs.begin(), end, arcs.end(), before);
  arcs.erase(end, arcs.end());
  return arcs;
}

MapRegions map_regions_of(const TileLayout& layout, std::size_t tiles, std::size_t max) {
  MapRegions regions;
  regions.of_tile.assign(tiles, MapRegions::nowhere);
  if (layout.cuts.empty()) {  // the tiles have no place in space, so a region is a range of tile numbers
    const std::size_t count = std::min(max, tiles);
    for (std::size_t t = 0; t < tiles; ++t) regions.of_tile[t] = static_cast<std::uint16_t>(t * count / tiles);
    for (std::size_t region = 0; region < count; ++region)
      regions.codes.push_back(-1 - static_cast<std::int32_t>((2 * region + 1) * tiles / (2 * count)));
    return regions;
  }
  regions.codes = cut_up(layout.cuts, max);
  for (std::size_t region = 0; region < regions.codes.size(); ++region) {
    std::vector<std::int32_t> below{regions.codes[region]};
    while (!below.empty()) {
      const std::int32_t child = below.back();
      below.pop_back();
      if (child >= 0) {
        below.push_back(layout.cuts[static_cast<std::size_t>(child)].below);
        below.push_back(layout.cuts[static_cast<std::size_t>(child)].above);
      } else if (const auto tile = static_cast<std::size_t>(-1 - child); tile < tiles) {
        regions.of_tile[tile] = static_cast<std::uint16_t>(region);
      }
    }
  }
  return regions;
}

void RecentMail::add(const std::vector<MailArc>& arcs, Time now) {
  const std::lock_guard lock(mutex_);
  if (now - since_ >= half) {
    before_ = now - since_ < 2 * half ? std::move(now_) : Bytes();
    now_.clear();
    since_ = now;
  }
  for (const MailArc& arc : arcs) now_[{arc.from, arc.to}] += arc.bytes;
}

std::vector<MailArc> RecentMail::heaviest(Time now) const {
  std::vector<MailArc> arcs;
  {
    const std::lock_guard lock(mutex_);
    if (now - since_ >= 2 * half) return {};
    Bytes sum = now_;
    if (now - since_ < half) {
      for (const auto& [ends, bytes] : before_) sum[ends] += bytes;
    }
    for (const auto& [ends, bytes] : sum) arcs.push_back({ends.first, ends.second, bytes});
  }
  return tessera::heaviest(std::move(arcs), mail_arcs_max);
}

}  // namespace tessera
