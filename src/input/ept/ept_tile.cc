#include "src/input/ept/ept_tile.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/bytes/unpack.h"
#include "src/input/ept/ept_known.h"
#include "src/input/las/decimal_axis.h"
#include "src/input/las/las_reader.h"

namespace tessera::ept {
namespace {

// "PointSourceId" is point_source_id. A few have other names in LAS.
std::string attribute_name(const std::string& dimension) {
  if (dimension == "ScanAngleRank") return "scan_angle";
  if (dimension == "KeyPoint" || dimension == "Keypoint") return "key_point";
  std::string name;
  for (std::size_t i = 0; i < dimension.size(); ++i) {
    const auto c = static_cast<unsigned char>(dimension[i]);
    const bool starts_word =
        std::isupper(c) != 0 && i > 0 && std::islower(static_cast<unsigned char>(dimension[i - 1])) != 0;
    if (starts_word) name += '_';
    name += static_cast<char>(std::tolower(c));
  }
  return name;
}

bool is_coordinate(const Dimension& dimension) {
  return dimension.name == "X" || dimension.name == "Y" || dimension.name == "Z";
}

// A dimension whose numbers are copied to a place in a row. Scaled ones become doubles.
struct Copied {
  Dimension from;
  std::size_t to;
  AttributeType type;
};

std::vector<Copied> copied(const Info& info, const std::vector<Attribute>& schema) {
  std::vector<Copied> list;
  const auto offsets = row_offsets(schema);
  const auto there = attributes_of(info);
  std::size_t number = 0;
  for (const auto& dimension : info.dimensions) {
    if (is_coordinate(dimension)) continue;
    for (std::size_t i = 0; i < schema.size(); ++i)
      if (there[number].name == schema[i].name) list.push_back({dimension, offsets[i], schema[i].type});
    ++number;
  }
  return list;
}

// The records of a tile without a header.
class BinaryTile : public PointReader {
 public:
  BinaryTile(const Info& info, FileInfo file, RecordStream records, const std::vector<Attribute>& schema)
      : file_(std::move(file)),
        records_(std::move(records)),
        copied_(copied(info, schema)),
        row_bytes_(row_bytes(schema)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      coordinates_[axis] = *find(info, std::string(1, "XYZ"[axis]));
      // Integers are decimals, as in LAS.
      if (coordinates_[axis].type == AttributeType::i32)
        decimals_[axis].emplace(coordinates_[axis].scale, coordinates_[axis].offset);
    }
  }

  const FileInfo& info() const override { return file_; }

  Status next(PointBatch& batch, std::size_t most) override {
    BOOST_OUTCOME_TRY(block, records_.next(points_at_once(most, row_bytes_)));
    const std::size_t n = block.size() / records_.record_bytes();
    batch.points.assign(n, Point{});
    batch.rows.assign(n * row_bytes_, std::byte{0});
    for (int axis = 0; axis < 3; ++axis) copy_axis(axis, block.data(), batch.points);
    for (const auto& column : copied_) copy_column(column, block.data(), n, batch.rows);
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    records_.seek(index);
    return true;
  }

  std::string place(std::size_t index) const override {
    return "record " + std::to_string(records_.first_of_last_block() + index);
  }

 private:
  void copy_axis(int axis, const std::byte* records, std::vector<Point>& points) {
    const auto& dimension = coordinates_[static_cast<std::size_t>(axis)];
    const auto& decimal = decimals_[static_cast<std::size_t>(axis)];
    const std::byte* from = records + dimension.at;
    const std::size_t stride = records_.record_bytes();
    if (decimal) {
      for (auto& p : points) {
        p[axis] = (*decimal)(load<std::int32_t>(from));
        from += stride;
      }
      return;
    }
    auto* to = reinterpret_cast<std::byte*>(points.data()) + static_cast<std::size_t>(axis) * sizeof(double);
    column_copy(dimension.type, false, AttributeType::f64)(from, stride, to, sizeof(Point), points.size());
    if (dimension.plain()) return;
    for (auto& p : points) p[axis] = p[axis] * dimension.scale + dimension.offset;
  }

  void copy_column(const Copied& column, const std::byte* records, std::size_t n, std::vector<std::byte>& rows) {
    if (n == 0) return;
    const auto& from = column.from;
    const std::size_t stride = records_.record_bytes();
    if (from.plain()) {
      column_copy(from.type, false, column.type)(records + from.at, stride, rows.data() + column.to, row_bytes_, n);
      return;
    }
    scratch_.resize(n);
    auto* scratch = reinterpret_cast<std::byte*>(scratch_.data());
    column_copy(from.type, false, AttributeType::f64)(records + from.at, stride, scratch, sizeof(double), n);
    for (auto& value : scratch_) value = value * from.scale + from.offset;
    column_copy(AttributeType::f64, false, column.type)(scratch, sizeof(double), rows.data() + column.to, row_bytes_,
                                                        n);
  }

  FileInfo file_;
  RecordStream records_;
  std::array<Dimension, 3> coordinates_;
  std::array<std::optional<DecimalAxis>, 3> decimals_;
  std::vector<Copied> copied_;
  std::size_t row_bytes_;
  std::vector<double> scratch_;
};

// Unpacks a tile of known size into memory: tiles are small parts of a cloud.
Result<std::unique_ptr<ByteSource>> unpacked_tile(const ByteSource& packed, std::uint64_t bytes) {
  const std::string name = packed.path().string();
  std::vector<std::byte> content;
  std::uint64_t at = 0;
  InputBuffer in([&](std::span<std::byte> out) -> Result<std::size_t> {
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), packed.size() - at));
    BOOST_OUTCOME_TRYV(packed.read(at, out.first(n)));
    at += n;
    return n;
  });
  BOOST_OUTCOME_TRYV(unpack(FileFormat::zstd, in, name, [&](std::span<const std::byte> block) -> Status {
    if (block.size() > bytes - content.size())
      return error(Errc::bad_input, name + ": has more points than the hierarchy says");
    content.insert(content.end(), block.begin(), block.end());
    return success();
  }));
  return memory_source(packed.path(), std::move(content));
}

}  // namespace

std::vector<Attribute> attributes_of(const Info& info) {
  std::vector<Attribute> attributes;
  AttributeNames names;
  for (const auto& dimension : info.dimensions)
    if (!is_coordinate(dimension))
      attributes.push_back(
          {names.make(attribute_name(dimension.name)), dimension.plain() ? dimension.type : AttributeType::f64});
  return attributes;
}

Result<std::unique_ptr<PointReader>> open_tile(const ByteSource& ept, const Known& known, const Node& node,
                                               const std::vector<Attribute>& attributes, std::uint32_t threads) {
  const Info& info = known.info;
  const auto path = tile_file(info, node.key);
  BOOST_OUTCOME_TRY(source, known.files.open(ept, path));
  const auto differs = [&](std::uint64_t points) {
    return error(Errc::bad_input, path.string() + ": has " + std::to_string(points) +
                                      " points, and the hierarchy says that it has " + std::to_string(node.points));
  };
  if (info.tiles == Info::Tiles::laz) {
    BOOST_OUTCOME_TRY(reader, open_las(std::move(source), attributes, ReadHints{.threads = threads}));
    const auto points = reader->info().points.value_or(0);
    if (points != node.points) return differs(points);
    return reader;
  }
  const std::uint64_t bytes = node.points * info.record_bytes;
  if (info.tiles == Info::Tiles::zstd) {
    BOOST_OUTCOME_TRY(content, unpacked_tile(*source, bytes));
    BOOST_OUTCOME_TRYV(source->check_unchanged());
    source = std::move(content);
  }
  if (source->size() % info.record_bytes != 0)
    return error(Errc::bad_input, path.string() + ": has " + std::to_string(source->size()) +
                                      " bytes, and a record has " + std::to_string(info.record_bytes));
  if (source->size() != bytes) return differs(source->size() / info.record_bytes);
  FileInfo file = info_of(*source, "ept");
  RecordStream records(std::move(source), 0, info.record_bytes, node.points);
  return std::unique_ptr<PointReader>(new BinaryTile(info, std::move(file), std::move(records), attributes));
}

}  // namespace tessera::ept
