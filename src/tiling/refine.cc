#include "src/tiling/refine.h"

#include <algorithm>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "src/files/checksum.h"
#include "src/files/disk_file.h"
#include "src/files/names.h"
#include "src/files/whole_file.h"

namespace tessera {
namespace {

constexpr std::size_t chunk_points = 32768;

struct TileFiles {
  std::filesystem::path points, rows;
  TileSums written;
};

using Visit = std::function<Status(std::span<const LocalPoint>, std::span<const std::byte>)>;

// The records of a tile in order, in chunks; without their rows if row_bytes is 0. Error corrupt, at the end, when they
// are not those that were written.
Status for_each_chunk(const TileFiles& files, std::size_t row_bytes, const std::stop_token& stop, const Visit& visit) {
  BOOST_OUTCOME_TRY(points_file, DiskFile::open(files.points, DiskFile::Mode::read));
  std::vector<LocalPoint> points(chunk_points);
  std::vector<std::byte> rows(chunk_points * row_bytes);
  // The rows' file is opened only if there are rows; Result has no empty state, so the points' file stands in.
  BOOST_OUTCOME_TRY(rows_file, DiskFile::open(row_bytes > 0 ? files.rows : files.points, DiskFile::Mode::read));
  TileSums sums;
  std::uint64_t records = 0;
  while (true) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while tiles were split");
    BOOST_OUTCOME_TRY(bytes, points_file.read(std::as_writable_bytes(std::span(points))));
    const std::size_t n = bytes / sizeof(LocalPoint);
    if (n == 0) break;
    const auto part = std::span(rows).first(n * row_bytes);
    BOOST_OUTCOME_TRY(got, rows_file.read(part));
    if (got != part.size()) return error(Errc::io, files.rows.string() + ": was cut short by another program");
    sums.points += record_checksum(std::as_bytes(std::span(points).first(n)), sizeof(LocalPoint), records);
    if (row_bytes > 0) sums.rows += record_checksum(part, row_bytes, records);
    records += n;
    BOOST_OUTCOME_TRYV(visit(std::span(points).first(n), part));
  }
  if (sums.points != files.written.points) return wrong_sum(files.points, sums.points, files.written.points);
  if (row_bytes > 0 && sums.rows != files.written.rows) return wrong_sum(files.rows, sums.rows, files.written.rows);
  return success();
}

// Splits `tile` in memory until each part should be below the limit; `points` are every `stride`-th of the tile.
// Returns whether it was split at all.
bool split_by_sample(Partition& partition, TileId tile, std::vector<Point> points, std::uint64_t stride,
                     std::uint64_t limit) {
  bool any = false;
  std::vector<std::pair<TileId, std::vector<Point>>> parts;
  parts.emplace_back(tile, std::move(points));
  while (!parts.empty()) {
    auto [part, inside] = std::move(parts.back());
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

}  // namespace

Status split_large_tiles(Partition& partition, TileWriter& writer, const std::filesystem::path& folder,
                         std::size_t row_bytes, std::uint64_t limit, std::uint64_t memory_bytes, std::stop_token stop) {
  if (partition.kind() == PartitionKind::random) return success();
  // The sample, the copy that split() orders, and the halves.
  const std::uint64_t sample_max = std::max<std::uint64_t>(4096, memory_bytes / (3 * sizeof(Point)));
  TileFiles taken{split_points_file(folder), split_attributes_file(folder), {}};
  std::vector<TileId> large;
  for (std::uint32_t t = 0; t < partition.tiles(); ++t) {
    if (writer.counts()[t] > limit) large.push_back(TileId{t});
  }
  while (!large.empty()) {
    const TileId tile = large.back();
    large.pop_back();
    const TileFiles own{points_file(folder, tile), attributes_file(folder, tile), writer.sums()[tile.value]};
    const std::uint64_t count = writer.counts()[tile.value];
    const Bounds bounds = writer.bounds()[tile.value];
    const std::uint64_t stride = (count + sample_max - 1) / sample_max;
    std::vector<Point> sample;
    sample.reserve(count / stride + 1);
    std::uint64_t seen = 0;
    BOOST_OUTCOME_TRYV(for_each_chunk(own, 0, stop, [&](auto points, auto) -> Status {
      for (const LocalPoint& p : points) {
        if (seen++ % stride == 0) sample.push_back(p.at);
      }
      return success();
    }));
    const std::uint32_t first_new = partition.tiles();
    // Equal points in the sample need not be all: then the tile's bounds are split, each of whose sides has a point.
    if (!split_by_sample(partition, tile, std::move(sample), stride, limit) &&
        !(stride > 1 && partition.split(tile, {bounds.lo, bounds.hi}))) {
      continue;
    }
    BOOST_OUTCOME_TRYV(rename_file(own.points, taken.points));
    if (row_bytes > 0) {
      BOOST_OUTCOME_TRYV(rename_file(own.rows, taken.rows));
    }
    taken.written = own.written;
    writer.restart(tile);
    BOOST_OUTCOME_TRYV(for_each_chunk(
        taken, row_bytes, stop, [&](auto points, auto rows) -> Status { return writer.add(partition, points, rows); }));
    BOOST_OUTCOME_TRYV(writer.flush(partition));
    BOOST_OUTCOME_TRYV(remove_file(taken.points));
    if (row_bytes > 0) {
      BOOST_OUTCOME_TRYV(remove_file(taken.rows));
    }
    // With every point in the sample, what is above the limit now are equal points.
    if (stride == 1) continue;
    if (writer.counts()[tile.value] > limit) large.push_back(tile);
    for (std::uint32_t t = first_new; t < partition.tiles(); ++t) {
      if (writer.counts()[t] > limit) large.push_back(TileId{t});
    }
  }
  return success();
}

}  // namespace tessera
