#include "src/tiling/tile_writer.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/disk_file.h"
#include "src/base/files/names.h"

namespace tessera {
namespace {

constexpr std::uint64_t capacity_min = 4096;
constexpr std::uint64_t capacity_max = std::uint64_t{1} << 31;
constexpr std::size_t ahead = 24;            // records that are prefetched
constexpr std::size_t block_points = 16384;  // gathered, then written: 512 KB stay in the second-level cache

// Gathers records into blocks, writes them, and computes their checksums by segment.
class Gathered {
 public:
  Gathered(DiskFile& file, std::vector<std::byte>& block, std::size_t record_bytes)
      : file_(file), block_(block), record_bytes_(record_bytes) {
    block_.resize(block_points * record_bytes);
  }

  Status add(const std::byte* record) {
    std::memcpy(block_.data() + used_, record, record_bytes_);
    used_ += record_bytes_;
    return used_ < block_.size() ? success() : write();
  }

  // Returns the checksum of the records since the last call.
  std::uint64_t sum() {
    summed();
    return std::exchange(sum_, 0);
  }

  Status write() {
    summed();
    BOOST_OUTCOME_TRYV(file_.write(std::span(block_).first(used_)));
    used_ = unsummed_ = 0;
    return success();
  }

 private:
  void summed() {
    const auto records = std::span(block_).subspan(unsummed_, used_ - unsummed_);
    if (records.empty()) return;
    sum_ += record_checksum(records, record_bytes_, number_);
    number_ += records.size() / record_bytes_;
    unsummed_ = used_;
  }

  DiskFile& file_;
  std::vector<std::byte>& block_;
  std::size_t record_bytes_, used_ = 0, unsummed_ = 0;
  std::uint64_t number_ = 0, sum_ = 0;
};

}  // namespace

TileWriter::TileWriter(std::filesystem::path run_folder, std::uint32_t attempt, int dimension, std::size_t row_bytes,
                       std::uint64_t buffer_bytes, const Period& period)
    : folder_(std::move(run_folder)),
      attempt_(attempt),
      row_bytes_(row_bytes),
      capacity_(
          static_cast<std::size_t>(std::clamp(buffer_bytes / bytes_per_point(row_bytes), capacity_min, capacity_max))),
      routed_(dimension, period) {
  // The memory is reserved, not touched: a small cloud uses a small part of it.
  points_.reserve(capacity_);
  rows_.reserve(capacity_ * row_bytes_);
  tiles_.reserve(capacity_);
  by_tile_.reserve(capacity_);
}

Status TileWriter::add(const Partition& partition, std::span<const LocalPoint> points,
                       std::span<const std::byte> rows) {
  routed_.resize(partition.tiles());
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
  if (points_.empty()) return success();
  std::vector<std::uint32_t> end(partition.tiles() + 1);  // by tile: where its indices end, once they are placed
  for (const TileId tile : tiles_) ++end[tile.value + 1];
  for (std::size_t t = 1; t < end.size(); ++t) end[t] += end[t - 1];
  by_tile_.resize(tiles_.size());
  for (std::size_t i = 0; i < tiles_.size(); ++i) by_tile_[end[tiles_[i].value]++] = static_cast<std::uint32_t>(i);

  const auto bundle = static_cast<std::uint32_t>(routed_.bundles.size());
  routed_.bundles.push_back({{attempt_, bundles_++}, 0, points_.size()});
  std::vector<TileId> filled;
  for (std::uint32_t t = 0, begin = 0; t < partition.tiles(); begin = end[t++]) {
    if (end[t] == begin) continue;
    filled.push_back(TileId{t});
    Segment segment{.bundle = bundle, .count = end[t] - begin, .begin = begin};
    segment.first_id = points_[by_tile_[begin]].id.value;
    routed_.segments[t].push_back(segment);
  }
  const ShuffleFileId id = routed_.bundles.back().id;
  BOOST_OUTCOME_TRYV(write(points_file(folder_, id), std::as_bytes(std::span(points_)), filled, &Segment::points_sum,
                           [&](TileId tile, std::size_t i) {
                             routed_.bounds[tile.value].add(points_[i].at);
                             routed_.seeds.add(tile, partition.boxes()[tile.value], points_[i]);
                           }));
  if (row_bytes_ > 0) {
    BOOST_OUTCOME_TRYV(write(attributes_file(folder_, id), rows_, filled, &Segment::rows_sum, [](auto...) {}));
  }
  points_.clear();
  rows_.clear();
  tiles_.clear();
  return success();
}

// Writes a file of the last shuffle file's records. `seen` is called with each record's tile and index.
template <class Seen>
Status TileWriter::write(const std::filesystem::path& path, std::span<const std::byte> records,
                         std::span<const TileId> filled, std::uint64_t Segment::*sum, Seen seen) {
  const std::size_t record_bytes = records.size() / points_.size();
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::replace));
  Gathered gathered(file, block_, record_bytes);
  for (const TileId tile : filled) {
    Segment& segment = routed_.segments[tile.value].back();
    const std::size_t end = segment.begin + segment.count;
    for (std::size_t k = segment.begin; k < end; ++k) {
      // In a cloud without order each record is somewhere else. The records that come soon are prefetched.
      __builtin_prefetch(records.data() + by_tile_[std::min(k + ahead, by_tile_.size() - 1)] * record_bytes);
      const std::size_t i = by_tile_[k];
      seen(tile, i);
      BOOST_OUTCOME_TRYV(gathered.add(records.data() + i * record_bytes));
    }
    segment.*sum = gathered.sum();
  }
  BOOST_OUTCOME_TRYV(gathered.write());
  return file.close();
}

}  // namespace tessera
