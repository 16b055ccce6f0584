// Reading the files of a run folder back. They are ours, but a disk can be full, a copy cut short: nothing is assumed.
#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include "src/files/checksum.h"
#include "src/files/disk_file.h"
#include "src/files/mapped_file.h"
#include "src/tiling/routed_run.h"

namespace tessera {

static_assert(std::endian::native == std::endian::little, "tile files are little endian and read without conversion");

namespace {

Status check_tile(const RoutedRun& run, TileId tile) {
  if (tile.value < run.tile_points.size()) return success();
  return error(Errc::internal, "tile " + std::to_string(tile.value) + " of " + std::to_string(run.tile_points.size()));
}

// Once for each tile in this process: rows are looked up here and there in mapped files, which never reads all of them.
// Two threads may both check a tile; that costs time, not truth.
Status check_files(const RoutedRun& run, TileId tile, std::size_t row) {
  TileChecked not_remembered;
  TileChecked& checked = run.checked ? (*run.checked)[tile.value] : not_remembered;
  const std::uint64_t count = run.tile_points[tile.value];
  const TileSums& sums = run.tile_sums[tile.value];
  if (!checked.points) {
    BOOST_OUTCOME_TRYV(check_records(points_file(run.folder, tile), count, sizeof(LocalPoint), sums.points));
    checked.points = true;
  }
  if (!checked.rows) {
    BOOST_OUTCOME_TRYV(check_records(attributes_file(run.folder, tile), count, row, sums.rows));
    checked.rows = true;
  }
  return success();
}

LocalPoint record(std::span<const std::byte> records, std::size_t i) {
  LocalPoint p;
  std::memcpy(&p, records.data() + i * sizeof p, sizeof p);
  return p;
}

}  // namespace

Result<LoadedTile> load_tile(const RoutedRun& run, TileId tile) {
  BOOST_OUTCOME_TRYV(check_tile(run, tile));
  const std::uint64_t count = run.tile_points[tile.value];
  if (count == 0) return LoadedTile{};
  const auto path = points_file(run.folder, tile);
  std::vector<LocalPoint> points;
  {
    BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
    BOOST_OUTCOME_TRY(bytes, file.size());
    if (bytes != count * sizeof(LocalPoint)) return wrong_size(path, bytes, count, sizeof(LocalPoint));
    points.resize(count);
    BOOST_OUTCOME_TRY(got, file.read(std::as_writable_bytes(std::span(points))));
    if (got != bytes) return wrong_size(path, got, count, sizeof(LocalPoint));
  }
  const std::uint64_t sum = record_checksum(std::as_bytes(std::span(points)), sizeof(LocalPoint), 0);
  if (const auto written = run.tile_sums[tile.value].points; sum != written) return wrong_sum(path, sum, written);
  if (run.checked) (*run.checked)[tile.value].points = true;
  const Box& box = run.partition.boxes()[tile.value];
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LocalPoint& p = points[i];
    // The checksum tells that these are the bytes that were written; this, that they were the right ones.
    if (!is_finite(p.at) || !box.contains(p.at) || (i > 0 && p.id <= points[i - 1].id)) {
      return damaged_run(
          path, "record " + std::to_string(i) + " is not a point of this tile with an id above the one before");
    }
  }
  return order_points(std::move(points), run.dimension);
}

Result<std::vector<std::byte>> load_rows(const RoutedRun& run, TileId tile, const std::vector<PointId>& ids) {
  BOOST_OUTCOME_TRYV(check_tile(run, tile));
  const std::size_t row = row_bytes(run.schema);
  std::vector<std::byte> rows(ids.size() * row);
  if (rows.empty()) return rows;
  const std::uint64_t count = run.tile_points[tile.value];
  const auto path = points_file(run.folder, tile);
  const auto rows_path = attributes_file(run.folder, tile);
  if (count == 0) return damaged_run(path, "is empty, but point " + to_string(ids[0]) + " is wanted");
  BOOST_OUTCOME_TRYV(check_files(run, tile, row));
  BOOST_OUTCOME_TRY(points_map, MappedFile::open(path));
  BOOST_OUTCOME_TRY(rows_map, MappedFile::open(rows_path));
  const auto points = points_map.bytes();
  const auto from = rows_map.bytes();
  if (points.size() != count * sizeof(LocalPoint)) return wrong_size(path, points.size(), count, sizeof(LocalPoint));
  if (from.size() != count * row) return wrong_size(rows_path, from.size(), count, row);

  // Both sorted by id, so one pass; it gallops, since a neighbour tile asks for a few ids among a million.
  std::vector<std::size_t> order(ids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
  std::size_t low = 0;  // no record before it has an id >= the one looked for
  for (const std::size_t i : order) {
    std::size_t step = 1;
    std::size_t high = low;
    while (high < count && record(points, high).id < ids[i]) {
      low = high + 1;
      high += step;
      step *= 2;
    }
    high = std::min<std::size_t>(high, count);
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (record(points, middle).id < ids[i]) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    if (low == count || record(points, low).id != ids[i]) {
      return damaged_run(path, "has no point " + to_string(ids[i]));
    }
    std::memcpy(rows.data() + i * row, from.data() + low * row, row);
  }
  return rows;
}

}  // namespace tessera
