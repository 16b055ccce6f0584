// Reading the files of a run folder back. They are ours, but a disk can be full, a copy cut short: nothing is assumed.
#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include "src/tiling/disk_file.h"
#include "src/tiling/routed_run.h"

namespace tessera {

static_assert(std::endian::native == std::endian::little, "tile files are little endian and read without conversion");

namespace {

std::filesystem::path numbered(const std::filesystem::path& folder, const char* kind, TileId tile) {
  char name[32];
  std::snprintf(name, sizeof name, "%06u.bin", tile.value);
  return folder / kind / name;
}

Error wrong_size(const std::filesystem::path& path, std::uint64_t bytes, std::uint64_t points, std::size_t record) {
  return error(Errc::corrupt, path.string() + ": has " + std::to_string(bytes) + " bytes, but " +
                                  std::to_string(points) + " records of " + std::to_string(record) +
                                  " bytes were written");
}

Status check_tile(const RoutedRun& run, TileId tile) {
  if (tile.value < run.tile_points.size()) return success();
  return error(Errc::internal, "tile " + std::to_string(tile.value) + " of " + std::to_string(run.tile_points.size()));
}

LocalPoint record(std::span<const std::byte> records, std::size_t i) {
  LocalPoint p;
  std::memcpy(&p, records.data() + i * sizeof p, sizeof p);
  return p;
}

}  // namespace

std::filesystem::path points_file(const std::filesystem::path& run_folder, TileId tile) {
  return numbered(run_folder, "points", tile);
}

std::filesystem::path attributes_file(const std::filesystem::path& run_folder, TileId tile) {
  return numbered(run_folder, "attributes", tile);
}

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
  const Box& box = run.partition.boxes()[tile.value];
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LocalPoint& p = points[i];
    // A block of zeros after a crash, or a file of another tile, fails one of these.
    if (!is_finite(p.at) || !box.contains(p.at) || (i > 0 && p.id <= points[i - 1].id)) {
      return error(Errc::corrupt, path.string() + ", record " + std::to_string(i) +
                                      ": is not a point of this tile with an id above the one before");
    }
  }
  return order_points(std::move(points), run.dimension);
}

Result<std::vector<std::byte>> load_rows(const RoutedRun& run, TileId tile, const std::vector<std::uint64_t>& ids) {
  BOOST_OUTCOME_TRYV(check_tile(run, tile));
  const std::size_t row = row_bytes(run.schema);
  std::vector<std::byte> rows(ids.size() * row);
  if (rows.empty()) return rows;
  const std::uint64_t count = run.tile_points[tile.value];
  const auto path = points_file(run.folder, tile);
  const auto rows_path = attributes_file(run.folder, tile);
  if (count == 0)
    return error(Errc::corrupt, path.string() + ": is empty, but point " + std::to_string(ids[0]) + " is wanted");
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
      return error(Errc::corrupt, path.string() + ": has no point " + std::to_string(ids[i]));
    }
    std::memcpy(rows.data() + i * row, from.data() + low * row, row);
  }
  return rows;
}

}  // namespace tessera
