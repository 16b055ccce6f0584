// Reads the files of a run folder back. Tessera wrote them, but a disk can be full and a copy incomplete, so nothing is
// assumed.
#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include "src/base/big_vector.h"
#include "src/base/files/names.h"
#include "src/tiling/kept_points.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

static_assert(std::endian::native == std::endian::little, "tile files are little endian and read without conversion");

namespace {

Status check_tile(const RoutedCloud& run, TileId tile) {
  if (tile.value < run.tile_points.size()) return success();
  return error(Errc::internal, "there is no tile " + std::to_string(tile.value) + ": the run has " +
                                   std::to_string(run.tile_points.size()) + " tiles");
}

// Checks all records of a tile, once in this process. Rows are looked up here and there in mapped files, so reading
// them never covers all of them. Two threads may both check a tile; that costs time, not correctness.
Status check_records(const RoutedCloud& run, TileId tile) {
  TileChecked not_remembered;
  TileChecked& checked = run.checked ? (*run.checked)[tile.value] : not_remembered;
  const ShuffleFiles points_alone{run.folder, run.bundles, 0};
  if (!checked.points) {
    BOOST_OUTCOME_TRYV(
        for_each_record(points_alone, run.segments_of(tile), {}, [](auto...) -> Status { return success(); }));
    checked.points = true;
  }
  if (checked.rows) return success();
  for (const Segment& segment : run.segments_of(tile)) {
    BOOST_OUTCOME_TRYV(check_rows(run.files(), segment));
  }
  checked.rows = true;
  return success();
}

LocalPoint record(std::span<const std::byte> records, std::size_t i) {
  LocalPoint p;
  std::memcpy(&p, records.data() + i * sizeof p, sizeof p);
  return p;
}

}  // namespace

Result<LoadedTile> load_tile(const RoutedCloud& run, TileId tile) {
  BOOST_OUTCOME_TRYV(check_tile(run, tile));
  BigVector<LocalPoint> points(run.tile_points[tile.value]);
  const Box& box = run.partition.boxes()[tile.value];
  std::size_t begin = 0;
  for (const Segment& segment : run.segments_of(tile)) {
    const auto part = std::span(points).subspan(begin, segment.count);
    BOOST_OUTCOME_TRYV(read_points(run.files(), segment, part));
    for (std::size_t i = begin; i < begin + part.size(); ++i) {
      const LocalPoint& p = points[i];
      // The checksum says that these bytes were written. This test says that they are right.
      if (!is_finite(p.at) || !box.contains(p.at) || (i > 0 && p.id <= points[i - 1].id)) {
        return damaged_run(points_file(run.folder, run.bundles[segment.bundle].id),
                           "record " + std::to_string(segment.begin + i - begin) + " is not a point of tile " +
                               to_string(tile) + " with an id above that of the point before");
      }
    }
    begin += part.size();
  }
  if (run.checked) (*run.checked)[tile.value].points = true;
  LoadedTile loaded = order_points(points, run.dimension);
  BigVector<LocalPoint>().swap(points);
  BOOST_OUTCOME_TRYV(choose_kept(run, tile, loaded));
  return loaded;
}

Result<const ShuffleFileMaps::Maps*> ShuffleFileMaps::of(std::uint32_t number) {
  if (const auto found = maps_.find(number); found != maps_.end()) return &found->second;
  const ShuffleFile& bundle = run_.bundles[number];
  const std::size_t row = row_bytes(run_.schema);
  BOOST_OUTCOME_TRY(points, MappedFile::open(points_file(run_.folder, bundle.id)));
  BOOST_OUTCOME_TRY(rows, MappedFile::open(attributes_file(run_.folder, bundle.id)));
  if (points.bytes().size() < bundle.points * sizeof(LocalPoint) || rows.bytes().size() < bundle.points * row)
    return damaged_run(points_file(run_.folder, bundle.id), "was cut short by another program");
  return &maps_.emplace(number, Maps{std::move(points), std::move(rows)}).first->second;
}

Result<std::vector<std::byte>> load_rows(ShuffleFileMaps& maps, TileId tile, const std::vector<PointId>& ids) {
  const RoutedCloud& run = maps.run();
  BOOST_OUTCOME_TRYV(check_tile(run, tile));
  const std::size_t row = row_bytes(run.schema);
  std::vector<std::byte> rows(ids.size() * row);
  if (rows.empty()) return rows;
  const auto segments = run.segments_of(tile);
  const auto no_point = [&](PointId id) {
    return damaged_run(segments_file(run.folder), "tile " + to_string(tile) + " has no point " + to_string(id));
  };
  BOOST_OUTCOME_TRYV(check_records(run, tile));
  const auto first_id = [&](const Segment& s) { return PointId{run.bundles[s.bundle].first_id + s.first_id}; };

  // Both are sorted by id, so one pass is enough, one segment after the other.
  std::vector<std::size_t> order(ids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
  for (std::size_t next = 0; next < order.size();) {
    const PointId wanted = ids[order[next]];
    const auto after = std::upper_bound(segments.begin(), segments.end(), wanted,
                                        [&](PointId id, const Segment& s) { return id < first_id(s); });
    if (after == segments.begin()) return no_point(wanted);
    const Segment& segment = *std::prev(after);
    const ShuffleFile& bundle = run.bundles[segment.bundle];
    BOOST_OUTCOME_TRY(mapped, maps.of(segment.bundle));
    const auto points = mapped->points.bytes().subspan(segment.begin * sizeof(LocalPoint));
    const auto from = mapped->rows.bytes().subspan(segment.begin * row);
    // An exponential search, since a neighbour tile asks for a few ids among a million.
    std::size_t low = 0;  // no earlier record has an id >= the wanted one
    for (; next < order.size() && (after == segments.end() || ids[order[next]] < first_id(*after)); ++next) {
      const PointId id{ids[order[next]].value - bundle.first_id};
      std::size_t step = 1;
      std::size_t high = low;
      while (high < segment.count && record(points, high).id < id) {
        low = high + 1;
        high += step;
        step *= 2;
      }
      high = std::min<std::size_t>(high, segment.count);
      while (low < high) {
        const std::size_t middle = low + (high - low) / 2;
        if (record(points, middle).id < id) {
          low = middle + 1;
        } else {
          high = middle;
        }
      }
      if (low == segment.count || record(points, low).id != id) return no_point(ids[order[next]]);
      std::memcpy(rows.data() + order[next] * row, from.data() + low * row, row);
    }
  }
  return rows;
}

}  // namespace tessera
