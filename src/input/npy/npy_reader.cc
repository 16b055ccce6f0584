#include "src/input/npy/npy_reader.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/column_names.h"
#include "src/input/npy/npy_header.h"

namespace tessera {
namespace {

// Which column is which coordinate or attribute.
struct NpyRoles {
  std::array<std::optional<std::size_t>, 3> coordinates;
  struct Extra {
    Attribute attribute;
    std::size_t column;
  };
  std::vector<Extra> extras;
};

NpyRoles roles_by_option(const std::vector<NpyColumn>& columns, const std::vector<std::string>& names,
                         const ColumnNames& named) {
  NpyRoles roles;
  std::copy(named.coordinates.begin(), named.coordinates.end(), roles.coordinates.begin());
  AttributeNames unique;
  for (const std::size_t i : named.others) roles.extras.push_back({{unique.make(names[i]), columns[i].type}, i});
  return roles;
}

NpyRoles roles_of(const std::vector<NpyColumn>& columns) {
  NpyRoles roles;
  AttributeNames names;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::size_t letter = columns[i].name.size() == 1 ? std::string_view("xyzXYZ").find(columns[i].name) : 6;
    if (letter < 6 && !roles.coordinates[letter % 3])
      roles.coordinates[letter % 3] = i;
    else
      roles.extras.push_back({{names.make(columns[i].name), columns[i].type}, i});
  }
  return roles;
}

// Why these columns cannot be points, or "".
std::string check_coordinates(const std::vector<NpyColumn>& columns, const NpyRoles& roles) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& at = roles.coordinates[axis];
    if (!at && axis < 2) return std::string("has no column '") + "xy"[axis] + "'";
    if (at && (columns[*at].type == AttributeType::i64 || columns[*at].type == AttributeType::u64))
      return "the column '" + columns[*at].name +
             "' has integers of 64 bits, which doubles would round; save it as f8, or as integers of 32 bits";
  }
  return "";
}

class NpyReader : public PointReader {
 public:
  NpyReader(FileInfo info, RecordStream records, const std::vector<NpyColumn>& columns, const NpyRoles& roles,
            const std::vector<Attribute>& schema)
      : info_(std::move(info)), records_(std::move(records)), row_bytes_(row_bytes(schema)) {
    const auto copy = [&](const NpyColumn& from, std::size_t to, AttributeType type) {
      return Copied{from.offset, to, column_copy(from.type, from.swapped, type)};
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (roles.coordinates[axis])
        coordinates_.push_back(copy(columns[*roles.coordinates[axis]], axis * sizeof(double), AttributeType::f64));
    const auto offsets = row_offsets(schema);
    for (const auto& extra : roles.extras)
      for (std::size_t i = 0; i < schema.size(); ++i)
        if (extra.attribute.name == schema[i].name)
          values_.push_back(copy(columns[extra.column], offsets[i], schema[i].type));
  }

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    BOOST_OUTCOME_TRY(block, records_.next(points_at_once(most, row_bytes_)));
    const std::size_t stride = records_.record_bytes();
    const std::size_t n = block.size() / stride;
    batch.points.assign(n, Point{});
    batch.rows.assign(n * row_bytes_, std::byte{0});
    if (n == 0) return success();
    auto* points = reinterpret_cast<std::byte*>(batch.points.data());
    for (const auto& c : coordinates_) c.copy(block.data() + c.from, stride, points + c.to, sizeof(Point), n);
    for (const auto& c : values_) c.copy(block.data() + c.from, stride, batch.rows.data() + c.to, row_bytes_, n);
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    records_.seek(index);
    return true;
  }

  std::string place(std::size_t index) const override {
    return "row " + std::to_string(records_.first_of_last_block() + index);
  }

 private:
  struct Copied {
    std::size_t from, to;
    ColumnCopy copy;
  };

  FileInfo info_;
  RecordStream records_;
  std::size_t row_bytes_;
  std::vector<Copied> coordinates_, values_;
};

}  // namespace

Result<std::unique_ptr<PointReader>> open_npy(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints) {
  using By = CoordinateColumns::By;
  BOOST_OUTCOME_TRY(header, read_npy_header(*source));
  FileInfo info = info_of(*source, "npy");
  const bool by_option = !hints.columns.empty();
  NpyRoles roles;
  if (by_option) {
    const ColumnNames named = find_columns(hints.columns);
    if (const std::string wrong = too_few_columns(header.columns.size(), named); !wrong.empty())
      return error(Errc::bad_input, info.path.string() + ": " + wrong);
    roles = roles_by_option(header.columns, hints.columns, named);
  } else {
    roles = roles_of(header.columns);
  }
  if (const std::string wrong = check_coordinates(header.columns, roles); !wrong.empty())
    return error(Errc::bad_input, info.path.string() + ": " + wrong);
  info.detail = header.detail;
  info.dimension = roles.coordinates[2] ? 3 : 2;
  info.points = header.rows;
  for (const auto& extra : roles.extras) info.attributes.push_back(extra.attribute);
  info.columns = CoordinateColumns{{}, by_option ? By::option : header.named ? By::header : By::place};
  for (const auto& column : roles.coordinates)
    if (column) info.columns->numbers.push_back(*column + 1);
  RecordStream records(std::move(source), header.body_at, header.row_bytes, header.rows);
  BOOST_OUTCOME_TRYV(records.check_size());
  return std::unique_ptr<PointReader>(
      new NpyReader(std::move(info), std::move(records), header.columns, roles, attributes));
}

}  // namespace tessera
