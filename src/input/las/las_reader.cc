#include "src/input/las/las_reader.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/las/decimal_axis.h"
#include "src/input/las/las_header.h"
#include "src/input/laz/laz_file.h"

namespace tessera {
namespace {

struct LasColumn {
  LasField field;
  std::size_t row_offset;
  AttributeType type;
};

class LasReader : public PointReader {
 public:
  LasReader(FileInfo info, const LasHeader& header, std::unique_ptr<RecordSource> records,
            std::vector<LasColumn> columns, std::size_t row_bytes)
      : info_(std::move(info)),
        axes_{DecimalAxis(header.scale[0], header.offset[0]), DecimalAxis(header.scale[1], header.offset[1]),
              DecimalAxis(header.scale[2], header.offset[2])},
        records_(std::move(records)),
        row_bytes_(row_bytes),
        columns_(std::move(columns)) {}

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    BOOST_OUTCOME_TRY(block, records_->next(most));
    const std::size_t n = block.size() / records_->record_bytes();
    const std::uint64_t rank =
        n > 0 ? records_->first_of_last_block() : info_.points.value_or(0) + info_.points_passed_over;
    batch.passed_over = next_rank_ ? rank - *next_rank_ : 0;
    next_rank_ = rank + n;
    batch.points.resize(n);
    batch.rows.assign(n * row_bytes_, std::byte{0});
    if (n == 0) return success();
    decode_points(block.data(), batch.points);
    for (const auto& column : columns_) decode_column(column, block.data(), n, batch.rows);
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    records_->seek(index);
    next_rank_.reset();
    return true;
  }

  std::string place(std::size_t index) const override {
    return "record " + std::to_string(records_->first_of_last_block() + index);
  }

 private:
  void decode_points(const std::byte* record, std::vector<Point>& points) const {
    const std::size_t stride = records_->record_bytes();
    const auto& [x, y, z] = axes_;
    if (x.always_fast() && y.always_fast() && z.always_fast()) {
      for (auto& p : points) {
        p.x = x.fast(load<std::int32_t>(record));
        p.y = y.fast(load<std::int32_t>(record + 4));
        p.z = z.fast(load<std::int32_t>(record + 8));
        record += stride;
      }
      return;
    }
    for (auto& p : points) {
      p.x = x(load<std::int32_t>(record));
      p.y = y(load<std::int32_t>(record + 4));
      p.z = z(load<std::int32_t>(record + 8));
      record += stride;
    }
  }

  void decode_column(const LasColumn& column, const std::byte* records, std::size_t n, std::vector<std::byte>& rows) {
    const auto& field = column.field;
    const std::byte* from = records + field.offset;
    std::byte* to = rows.data() + column.row_offset;
    const std::size_t stride = records_->record_bytes();
    if (field.plain()) {
      column_copy(field.stored, false, column.type)(from, stride, to, row_bytes_, n);
      return;
    }
    scratch_.resize(n);
    auto* scratch = reinterpret_cast<std::byte*>(scratch_.data());
    if (field.stored == AttributeType::u8 && field.scale == 1 && field.add == 0) {
      for (std::size_t i = 0; i < n; ++i)
        scratch_[i] = (load<std::uint8_t>(from + i * stride) >> field.shift) & field.mask;
    } else {
      column_copy(field.stored, false, AttributeType::f64)(from, stride, scratch, sizeof(double), n);
      for (auto& value : scratch_) value = value * field.scale + field.add;
    }
    column_copy(AttributeType::f64, false, column.type)(scratch, sizeof(double), to, row_bytes_, n);
  }

  FileInfo info_;
  std::array<DecimalAxis, 3> axes_;
  std::unique_ptr<RecordSource> records_;
  std::size_t row_bytes_;
  std::optional<std::uint64_t> next_rank_ = 0;  // rank of the record after the last batch; none after a seek
  std::vector<LasColumn> columns_;
  std::vector<double> scratch_;
};

std::vector<LasColumn> columns_of(const std::vector<Attribute>& schema, const LasHeader& header) {
  std::vector<LasColumn> columns;
  const auto offsets = row_offsets(schema);
  for (std::size_t i = 0; i < schema.size(); ++i)
    for (const auto& field : header.fields)
      if (field.attribute.name == schema[i].name) columns.push_back({field, offsets[i], schema[i].type});
  return columns;
}

}  // namespace

Result<std::unique_ptr<PointReader>> open_las(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints) {
  BOOST_OUTCOME_TRY(header, read_las_header(*source));
  auto columns = columns_of(attributes, header);
  FileInfo info = info_of(*source, header.compressed ? "laz" : "las");
  info.detail = std::string(!header.compressed    ? "LAS"
                            : header.copc.empty() ? "LAZ"
                                                  : "COPC, LAZ") +
                " 1." + std::to_string(header.minor) + ", point format " + std::to_string(header.point_format);
  info.points = header.points;
  if (!header.bounds.empty()) info.bounds = header.bounds;
  info.step = {std::abs(header.scale[0]), std::abs(header.scale[1]), std::abs(header.scale[2])};
  info.crs = header.crs;
  info.crs_note = header.crs_note;
  info.levels = header.compressed && !header.copc.empty();
  for (const auto& field : header.fields) info.attributes.push_back(field.attribute);

  std::unique_ptr<RecordSource> records;
  if (header.compressed) {
    BOOST_OUTCOME_TRY(opened,
                      laz::open_laz_records(std::move(source), header, laz::wanted_fields(header, attributes), hints));
    info.points = opened.points;
    info.seek_points = opened.seek_points;
    info.points_passed_over = header.points - opened.points;
    records = std::move(opened.records);
  } else {
    auto stream =
        std::make_unique<RecordStream>(std::move(source), header.points_at, header.record_bytes, header.points);
    BOOST_OUTCOME_TRYV(stream->check_size());
    records = std::move(stream);
  }
  return std::unique_ptr<PointReader>(
      new LasReader(std::move(info), header, std::move(records), std::move(columns), row_bytes(attributes)));
}

}  // namespace tessera
