#include "src/tiling/tile_writer.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "src/files/checksum.h"
#include "src/files/disk_file.h"
#include "src/tiling/routed_run.h"

namespace tessera {
namespace {

constexpr std::uint64_t capacity_min = 4096;
constexpr std::uint64_t capacity_max = std::uint64_t{1} << 31;
constexpr std::size_t block_points = 16384;  // gathered, then written: 512 KB stay in the second-level cache

}  // namespace

TileWriter::TileWriter(std::filesystem::path run_folder, int dimension, std::size_t row_bytes,
                       std::uint64_t buffer_bytes)
    : folder_(std::move(run_folder)),
      row_bytes_(row_bytes),
      capacity_(
          static_cast<std::size_t>(std::clamp(buffer_bytes / bytes_per_point(row_bytes), capacity_min, capacity_max))),
      seeds_(dimension) {
  // Reserved, not touched: a small cloud uses a small part.
  points_.reserve(capacity_);
  rows_.reserve(capacity_ * row_bytes_);
  tiles_.reserve(capacity_);
  by_tile_.reserve(capacity_);
}

Status TileWriter::add(const Partition& partition, std::span<const LocalPoint> points,
                       std::span<const std::byte> rows) {
  counts_.resize(partition.tiles());
  bounds_.resize(partition.tiles());
  sums_.resize(partition.tiles());
  while (!points.empty()) {
    const std::size_t n = std::min(points.size(), capacity_ - points_.size());
    const std::size_t old = tiles_.size();
    points_.insert(points_.end(), points.begin(), points.begin() + static_cast<std::ptrdiff_t>(n));
    rows_.insert(rows_.end(), rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(n * row_bytes_));
    tiles_.resize(old + n);
    for (std::size_t i = 0; i < n; ++i) tiles_[old + i] = partition.tile_of(points[i].at);
    points = points.subspan(n);
    rows = rows.subspan(n * row_bytes_);
    if (points_.size() == capacity_) {
      BOOST_OUTCOME_TRYV(flush(partition));
    }
  }
  return success();
}

Status TileWriter::flush(const Partition& partition) {
  std::vector<std::uint32_t> end(counts_.size() + 1);  // by tile: where its indices end, once they are placed
  for (const TileId tile : tiles_) ++end[tile.value + 1];
  for (std::size_t t = 1; t < end.size(); ++t) end[t] += end[t - 1];
  by_tile_.resize(tiles_.size());
  for (std::size_t i = 0; i < tiles_.size(); ++i) by_tile_[end[tiles_[i].value]++] = static_cast<std::uint32_t>(i);
  std::uint32_t begin = 0;
  for (std::uint32_t t = 0; t < counts_.size(); ++t) {
    if (end[t] > begin) {
      BOOST_OUTCOME_TRYV(append(TileId{t}, partition.boxes()[t], std::span(by_tile_).subspan(begin, end[t] - begin)));
    }
    begin = end[t];
  }
  points_.clear();
  rows_.clear();
  tiles_.clear();
  return success();
}

Status TileWriter::append(TileId tile, const Box& box, std::span<const std::uint32_t> rows) {
  Bounds& bounds = bounds_[tile.value];
  TileSums& sums = sums_[tile.value];
  const std::uint64_t first = counts_[tile.value];  // of these records in the files
  block_.resize(block_points * std::max(sizeof(LocalPoint), row_bytes_));
  {
    BOOST_OUTCOME_TRY(file, DiskFile::open(points_file(folder_, tile), DiskFile::Mode::append));
    for (std::size_t begin = 0; begin < rows.size(); begin += block_points) {
      const auto part = rows.subspan(begin, std::min(block_points, rows.size() - begin));
      for (std::size_t i = 0; i < part.size(); ++i) {
        bounds.add(points_[part[i]].at);
        seeds_.add(tile, box, points_[part[i]]);
        std::memcpy(block_.data() + i * sizeof(LocalPoint), &points_[part[i]], sizeof(LocalPoint));
      }
      const auto records = std::span(block_).first(part.size() * sizeof(LocalPoint));
      sums.points += record_checksum(records, sizeof(LocalPoint), first + begin);
      BOOST_OUTCOME_TRYV(file.write(records));
    }
    BOOST_OUTCOME_TRYV(file.close());
  }
  counts_[tile.value] += rows.size();
  if (row_bytes_ == 0) return success();
  BOOST_OUTCOME_TRY(file, DiskFile::open(attributes_file(folder_, tile), DiskFile::Mode::append));
  for (std::size_t begin = 0; begin < rows.size(); begin += block_points) {
    const auto part = rows.subspan(begin, std::min(block_points, rows.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) {
      std::memcpy(block_.data() + i * row_bytes_, rows_.data() + part[i] * row_bytes_, row_bytes_);
    }
    const auto records = std::span(block_).first(part.size() * row_bytes_);
    sums.rows += record_checksum(records, row_bytes_, first + begin);
    BOOST_OUTCOME_TRYV(file.write(records));
  }
  return file.close();
}

void TileWriter::restart(TileId tile) {
  counts_[tile.value] = 0;
  bounds_[tile.value] = {};
  sums_[tile.value] = {};
  seeds_.restart(tile);
}

}  // namespace tessera
