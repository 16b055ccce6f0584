#include "src/tiling/routed_points.h"

#include <algorithm>
#include <utility>

#include "src/base/flat_codec.h"

namespace tessera {

void RoutedPoints::resize(std::uint32_t tiles) {
  segments.resize(tiles);
  bounds.resize(tiles);
}

std::uint64_t RoutedPoints::points_of(TileId tile) const {
  std::uint64_t points = 0;
  for (const Segment& segment : segments[tile.value]) points += segment.count;
  return points;
}

void RoutedPoints::append(const RoutedPoints& next) {
  const std::uint64_t first_id = counts.read;
  const auto first_bundle = static_cast<std::uint32_t>(bundles.size());
  for (ShuffleFile bundle : next.bundles) {
    bundle.first_id += first_id;
    bundles.push_back(bundle);
  }
  resize(static_cast<std::uint32_t>(std::max(segments.size(), next.segments.size())));
  for (std::size_t t = 0; t < next.segments.size(); ++t) {
    for (Segment segment : next.segments[t]) {
      segment.bundle += first_bundle;
      segments[t].push_back(segment);
    }
    bounds[t].add(next.bounds[t]);
  }
  seeds.add(next.seeds, first_id);
  span.add(next.span, first_id);
  counts.add(next.counts);
  of_files.resize(std::max(of_files.size(), next.of_files.size()));
  for (std::size_t i = 0; i < next.of_files.size(); ++i) of_files[i] += next.of_files[i];
}

std::vector<Segment> RoutedPoints::take(TileId tile) {
  bounds[tile.value] = {};
  seeds.restart(tile);
  return std::exchange(segments[tile.value], {});
}

BigVector<std::byte> to_bytes(const RoutedPoints& routed) {
  FlatWriter to;
  to.list(routed.bundles);
  std::uint64_t filled = 0;
  for (const auto& segments : routed.segments) filled += !segments.empty();
  to.value(filled);
  for (std::uint32_t t = 0; t < routed.segments.size(); ++t) {
    if (routed.segments[t].empty()) continue;
    to.value(t);
    to.list(routed.segments[t]);
    to.value(routed.bounds[t]);
  }
  routed.seeds.write(to);
  routed.span.write(to);
  to.value(routed.counts);
  to.list(routed.of_files);
  return to.take();
}

bool from_bytes(std::span<const std::byte> bytes, std::uint32_t tiles, RoutedPoints& routed) {
  FlatReader from(bytes);
  std::uint64_t filled = 0;
  if (!from.list(routed.bundles) || !from.value(filled)) return false;
  routed.resize(tiles);
  for (std::uint64_t i = 0; i < filled; ++i) {
    std::uint32_t t = 0;
    if (!from.value(t) || t >= tiles || !routed.segments[t].empty()) return false;
    if (!from.list(routed.segments[t]) || !from.value(routed.bounds[t])) return false;
    for (const Segment& segment : routed.segments[t]) {
      if (segment.bundle >= routed.bundles.size()) return false;
    }
  }
  return routed.seeds.read(from, tiles) && routed.span.read(from) && from.value(routed.counts) &&
         from.list(routed.of_files) && from.at_end();
}

}  // namespace tessera
