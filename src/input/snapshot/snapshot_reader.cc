#include "src/input/snapshot/snapshot_reader.h"

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"

namespace tessera::snapshot {
namespace {

// Where a column goes: into the coordinates, or into the rows.
struct Target {
  bool in_rows = false;
  std::size_t offset = 0;  // in a Point or in a row
  AttributeType type = AttributeType::f64;
};

class SnapshotReader : public PointReader {
 public:
  SnapshotReader(FileInfo info, std::unique_ptr<ByteSource> source, Layout layout, const std::vector<Attribute>& schema)
      : info_(std::move(info)),
        source_(std::move(source)),
        layout_(std::move(layout)),
        row_bytes_(row_bytes(schema)),
        targets_(3 + layout_.attributes.size()) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      targets_[axis].push_back({.in_rows = false, .offset = axis * sizeof(double), .type = AttributeType::f64});
    const auto offsets = row_offsets(schema);
    for (std::size_t i = 0; i < schema.size(); ++i)
      for (std::size_t a = 0; a < layout_.attributes.size(); ++a)
        if (layout_.attributes[a].name == schema[i].name)
          targets_[3 + a].push_back({.in_rows = true, .offset = offsets[i], .type = schema[i].type});
  }

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    const auto [begin_of_kept, end_of_kept] = layout_.kept.from(position_);
    batch.passed_over = begin_of_kept - position_;
    first_ = position_ = begin_of_kept;
    const auto n =
        static_cast<std::size_t>(std::min<std::uint64_t>(points_at_once(most, row_bytes_), end_of_kept - position_));
    batch.points.assign(n, Point{});
    batch.rows.assign(n * row_bytes_, std::byte{0});
    if (n == 0) return source_->check_unchanged();
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t column = 3; column < targets_.size(); ++column) fill(batch, column, 0, n, unknown);
    for (const auto& constant : layout_.constants) {
      const auto [begin, end] = part_of(constant.first, constant.count, n);
      if (begin < end) fill(batch, constant.column, begin, end, constant.value);
    }
    for (const auto& run : layout_.runs) {
      const auto [begin, end] = part_of(run.first, run.count, n);
      if (begin < end && is_wanted(run)) {
        BOOST_OUTCOME_TRYV(read(run, begin, end, batch));
      }
    }
    position_ += n;
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    position_ = layout_.kept.particle_of(index);
    return true;
  }

  std::string place(std::size_t index) const override { return "particle " + std::to_string(first_ + index); }

 private:
  // The particles of first .. first + count - 1 that are in the batch of `n` at position_, as places in the batch.
  std::pair<std::size_t, std::size_t> part_of(std::uint64_t first, std::uint64_t count, std::size_t n) const {
    const std::uint64_t begin = std::max(first, position_), end = std::min(first + count, position_ + n);
    if (begin >= end) return {0, 0};
    return {static_cast<std::size_t>(begin - position_), static_cast<std::size_t>(end - position_)};
  }

  bool is_wanted(const Run& run) const {
    return std::any_of(run.fields.begin(), run.fields.end(),
                       [&](const Field& f) { return !targets_[f.column].empty(); });
  }

  void fill(PointBatch& batch, std::size_t column, std::size_t begin, std::size_t end, double value) {
    for (const auto& target : targets_[column])
      copy(batch, target, AttributeType::f64, false, reinterpret_cast<const std::byte*>(&value), 0, begin, end);
  }

  void copy(PointBatch& batch, const Target& target, AttributeType from, bool swapped, const std::byte* bytes,
            std::size_t stride, std::size_t begin, std::size_t end) const {
    const std::size_t to_stride = target.in_rows ? row_bytes_ : sizeof(Point);
    std::byte* const to = target.in_rows ? batch.rows.data() : reinterpret_cast<std::byte*>(batch.points.data());
    column_copy(from, swapped, target.type)(bytes, stride, to + begin * to_stride + target.offset, to_stride,
                                            end - begin);
  }

  Status read(const Run& run, std::size_t begin, std::size_t end, PointBatch& batch) {
    block_.resize((end - begin) * run.record_bytes);
    const std::uint64_t record = position_ + begin - run.first;
    BOOST_OUTCOME_TRYV(source_->read(run.at + record * run.record_bytes, block_));
    for (const auto& field : run.fields)
      for (const auto& target : targets_[field.column])
        copy(batch, target, field.type, layout_.swapped, block_.data() + field.offset, run.record_bytes, begin, end);
    return success();
  }

  FileInfo info_;
  std::unique_ptr<ByteSource> source_;
  Layout layout_;
  std::size_t row_bytes_;
  std::vector<std::vector<Target>> targets_;  // of each column
  std::uint64_t position_ = 0, first_ = 0;
  std::vector<std::byte> block_;
};

}  // namespace

std::unique_ptr<PointReader> read_layout(FileInfo info, std::unique_ptr<ByteSource> source, Layout layout,
                                         const std::vector<Attribute>& schema) {
  info.points = layout.kept.points();
  info.points_passed_over = layout.kept.passed_over();
  info.attributes = layout.attributes;
  return std::make_unique<SnapshotReader>(std::move(info), std::move(source), std::move(layout), schema);
}

}  // namespace tessera::snapshot
