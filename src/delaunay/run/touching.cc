#include "src/delaunay/run/touching.h"

#include <algorithm>
#include <cstdint>

namespace tessera {
namespace {

// The outer boxes of a partition are not bounded.
Box cut_at_period(Box box, const Period& period) {
  for (int axis = 0; axis < 3; ++axis) {
    const double length = period.length[static_cast<std::size_t>(axis)];
    if (length == 0) continue;
    box.lo[axis] = std::max(box.lo[axis], 0.0);
    box.hi[axis] = std::min(box.hi[axis], length);
  }
  return box;
}

struct PlacedTile {
  TileId tile;
  Box box;
};

// The images of a tile that touch the box between 0 and the period, the tile itself among them.
void place(TileId tile, const Box& box, const Period& period, std::vector<PlacedTile>& out) {
  for (const PeriodOffset& o : period.offsets()) {
    const Box there{period.shifted(box.lo, o), period.shifted(box.hi, o)};
    bool touches = true;
    for (int axis = 0; axis < 3; ++axis) {
      const double length = period.length[static_cast<std::size_t>(axis)];
      touches &= length == 0 || (there.lo[axis] <= length && there.hi[axis] >= 0);
    }
    if (touches) out.push_back({image_of(tile, o), there});
  }
}

bool touch_across(const Box& a, const Box& b) {
  return a.lo.y <= b.hi.y && b.lo.y <= a.hi.y && a.lo.z <= b.hi.z && b.lo.z <= a.hi.z;
}

}  // namespace

std::shared_ptr<const std::vector<Box>> final_boxes(const std::shared_ptr<const Partition>& partition,
                                                    const Period& period) {
  if (partition->kind() == PartitionKind::random && partition->tiles() > 1)
    return std::make_shared<const std::vector<Box>>(partition->tiles(), Box{{1, 1, 1}, {-1, -1, -1}});
  if (!period.any()) return {partition, &partition->boxes()};
  auto boxes = std::make_shared<std::vector<Box>>(partition->boxes());
  for (Box& box : *boxes) box = cut_at_period(box, period);
  return boxes;
}

// A sweep along x: each box, in the order of lower sides, is compared with boxes that begin before it ends.
std::vector<std::vector<TileId>> touching_tiles(const Partition& partition, const std::vector<Bounds>& bounds,
                                                const Period& period) {
  const auto& boxes = partition.boxes();
  const auto tiles = static_cast<std::uint32_t>(boxes.size());
  std::vector<std::vector<TileId>> out(tiles);
  if (partition.kind() == PartitionKind::random) {
    for (std::uint32_t t = 0; t < tiles; ++t) {
      for (std::uint32_t i = 1; i < std::min(tiles, 33u); ++i) out[t].push_back(TileId{(t + i) % tiles});
      std::sort(out[t].begin(), out[t].end());
    }
    return out;
  }
  std::vector<PlacedTile> order;
  for (std::uint32_t t = 0; t < tiles; ++t) {
    if (!bounds[t].empty()) place(TileId{t}, cut_at_period(boxes[t], period), period, order);
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.box.lo.x < b.box.lo.x; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& [a, of_a] = order[i];
    for (std::size_t k = i + 1; k < order.size() && order[k].box.lo.x <= of_a.hi.x; ++k) {
      const auto& [b, of_b] = order[k];
      if (!touch_across(of_a, of_b)) continue;
      if (a == plain(a)) out[a.value].push_back(b);
      if (b == plain(b)) out[b.value].push_back(a);
    }
  }
  for (auto& list : out) {
    std::sort(list.begin(), list.end());
    list.shrink_to_fit();
  }
  return out;
}

}  // namespace tessera
