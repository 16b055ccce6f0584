#include "src/tiling/refine.h"

#include <algorithm>
#include <functional>
#include <span>
#include <utility>

namespace tessera {

bool split_by_sample(Partition& partition, TileId tile, std::vector<Point> points, std::uint64_t stride,
                     std::uint64_t limit) {
  bool any = false;
  std::vector<std::pair<TileId, std::vector<Point>>> parts;
  parts.emplace_back(tile, std::move(points));
  while (!parts.empty()) {
    const TileId part = parts.back().first;
    std::vector<Point> inside = std::move(parts.back().second);
    parts.pop_back();
    if (inside.size() * stride <= limit) continue;
    const TileId added{partition.tiles()};
    if (!partition.split(part, inside)) continue;
    any = true;
    const auto border =
        std::partition(inside.begin(), inside.end(), [&](const Point& p) { return partition.tile_of(p) == part; });
    std::vector<Point> above(border, inside.end());
    inside.erase(border, inside.end());
    parts.emplace_back(part, std::move(inside));
    parts.emplace_back(added, std::move(above));
  }
  return any;
}

Status split_large_tiles(Partition& partition, TileWriter& writer, const std::filesystem::path& folder,
                         std::size_t row_bytes, std::uint64_t limit, std::uint64_t memory_bytes, std::stop_token stop) {
  if (partition.kind() == PartitionKind::random) return success();
  // Memory for the sample, the copy that split() sorts, and the halves.
  const std::uint64_t sample_max = std::max<std::uint64_t>(4096, memory_bytes / (3 * sizeof(Point)));
  RoutedPoints& routed = writer.routed();
  std::vector<TileId> large;
  const auto look_at = [&](std::uint32_t t) {
    if (routed.points_of(TileId{t}) > limit) large.push_back(TileId{t});
  };
  for (std::uint32_t t = 0; t < partition.tiles(); ++t) look_at(t);
  while (!large.empty()) {
    const TileId tile = large.back();
    large.pop_back();
    const std::uint64_t count = routed.points_of(tile);
    const Bounds bounds = routed.bounds[tile.value];
    const std::uint64_t stride = (count + sample_max - 1) / sample_max;
    std::vector<Point> sample;
    sample.reserve(count / stride + 1);
    std::uint64_t seen = 0;
    const ShuffleFiles points_alone{folder, routed.bundles, 0};
    BOOST_OUTCOME_TRYV(
        for_each_record(points_alone, routed.segments[tile.value], stop, [&](auto points, auto) -> Status {
          for (const LocalPoint& p : points) {
            if (seen++ % stride == 0) sample.push_back(p.at);
          }
          return success();
        }));
    const std::uint32_t first_new = partition.tiles();
    // The sample may have equal points only, while the tile has others. Then the corners of the tile's bounds are used:
    // each side of that split has a point.
    if (!split_by_sample(partition, tile, std::move(sample), stride, limit) &&
        !(stride > 1 && partition.split(tile, {bounds.lo, bounds.hi}))) {
      continue;
    }
    // take() removes the tile from the account. While its records are read, the writer adds them to the account of the
    // new tiles, and to new shuffle files.
    const auto segments = routed.take(tile);
    const auto bundles = routed.bundles;
    BOOST_OUTCOME_TRYV(
        for_each_record({folder, bundles, row_bytes}, segments, stop,
                        [&](auto points, auto rows) -> Status { return writer.add(partition, points, rows); }));
    BOOST_OUTCOME_TRYV(writer.flush(partition));
    BOOST_OUTCOME_TRYV(give_back({folder, bundles, row_bytes}, segments));
    // If every point was in the sample, tiles that are still above the limit have equal points only.
    if (stride == 1) continue;
    look_at(tile.value);
    for (std::uint32_t t = first_new; t < partition.tiles(); ++t) look_at(t);
  }
  return success();
}

}  // namespace tessera
