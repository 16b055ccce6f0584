#include "src/delaunay/update/change_estimate.h"

#include <vector>

#include "src/delaunay/run/touching.h"

namespace tessera {

std::set<TileId> tiles_that_begin(const UpdatePlan& plan) {
  std::set<TileId> begin = plan.losing;
  for (const auto& [tile, points] : plan.added) begin.insert(tile);
  return begin;
}

ChangeEstimate estimate_change(const TileSource& source, const Partition& partition, const UpdatePlan& plan) {
  const std::set<TileId> begin = tiles_that_begin(plan);
  std::vector<Bounds> bounds(partition.tiles());
  const auto add = [&](TileId tile) {
    bounds.at(tile.value).add(partition.boxes().at(tile.value).lo);
    bounds.at(tile.value).add(partition.boxes().at(tile.value).hi);
  };
  for (const TileEntry& entry : source.manifest().tiles) add(entry.tile);
  for (const TileId tile : begin) add(tile);
  const auto touching = touching_tiles(partition, bounds);
  std::set<TileId> awake = begin;
  for (const TileId tile : begin) awake.insert(touching[tile.value].begin(), touching[tile.value].end());
  ChangeEstimate estimate{.begun = begin.size(), .awake = awake.size()};
  for (const TileId tile : awake) {
    const auto index = source.find(tile);
    if (!index) continue;
    estimate.points += source.entry(*index).own_points;
    estimate.bytes += source.entry(*index).bytes;
    if (begin.contains(tile)) estimate.begun_points += source.entry(*index).own_points;
  }
  return estimate;
}

}  // namespace tessera
