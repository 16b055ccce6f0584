#include "src/delaunay/update/known_in_change.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "src/delaunay/run/touching.h"

namespace tessera {

// Partitions cover space, so new points lie inside the boxes.
KnownFromStart known_in_change(const Partition& partition, std::span<const TileId> tiles) {
  std::vector<Bounds> bounds(partition.tiles());
  for (const TileId tile : tiles) {
    bounds.at(tile.value).add(partition.boxes().at(tile.value).lo);
    bounds.at(tile.value).add(partition.boxes().at(tile.value).hi);
  }
  const auto neighbours = touching_tiles(partition, bounds);
  KnownFromStart known(std::move(bounds), neighbours, std::vector<Seed>{});
  known.leave_out_fresh_bit();
  return known;
}

KnownFromStart known_in_change(const Partition& partition) {
  std::vector<TileId> all;
  for (std::uint32_t t = 0; t < partition.tiles(); ++t) all.push_back(TileId{t});
  return known_in_change(partition, all);
}

}  // namespace tessera
