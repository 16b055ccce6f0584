#include "src/delaunay/run/touching.h"

#include <algorithm>
#include <cstdint>

namespace tessera {

std::shared_ptr<const std::vector<Box>> final_boxes(const std::shared_ptr<const Partition>& partition) {
  if (partition->kind() != PartitionKind::random || partition->tiles() == 1) return {partition, &partition->boxes()};
  return std::make_shared<const std::vector<Box>>(partition->tiles(), Box{{1, 1, 1}, {-1, -1, -1}});
}

// A sweep along x: each box, in the order of lower sides, is compared with boxes that begin before it ends.
std::vector<std::vector<TileId>> touching_tiles(const Partition& partition, const std::vector<Bounds>& bounds) {
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
  std::vector<std::uint32_t> order;
  for (std::uint32_t t = 0; t < tiles; ++t) {
    if (!bounds[t].empty()) order.push_back(t);
  }
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return boxes[a].lo.x < boxes[b].lo.x; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Box& a = boxes[order[i]];
    for (std::size_t k = i + 1; k < order.size() && boxes[order[k]].lo.x <= a.hi.x; ++k) {
      const Box& b = boxes[order[k]];
      if (a.lo.y > b.hi.y || b.lo.y > a.hi.y || a.lo.z > b.hi.z || b.lo.z > a.hi.z) continue;
      out[order[i]].push_back(TileId{order[k]});
      out[order[k]].push_back(TileId{order[i]});
    }
  }
  for (auto& list : out) {
    std::sort(list.begin(), list.end());
    list.shrink_to_fit();
  }
  return out;
}

}  // namespace tessera
