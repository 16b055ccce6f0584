#include "src/input/e57/e57_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/e57/e57_header.h"
#include "src/input/e57/e57_pages.h"
#include "src/input/e57/e57_stream.h"

namespace tessera {
namespace {

constexpr std::array<std::string_view, 3> cartesian{"cartesianX", "cartesianY", "cartesianZ"};
constexpr std::array<std::string_view, 3> spherical{"sphericalRange", "sphericalAzimuth", "sphericalElevation"};
constexpr std::string_view cartesian_state = "cartesianInvalidState", spherical_state = "sphericalInvalidState";

std::optional<std::size_t> find(const E57Scan& scan, std::string_view name) {
  for (std::size_t i = 0; i < scan.fields.size(); ++i)
    if (scan.fields[i].name == name && scan.fields[i].kind != E57Field::Kind::text) return i;
  return std::nullopt;
}

bool has_all(const E57Scan& scan, const std::array<std::string_view, 3>& names) {
  return std::all_of(names.begin(), names.end(), [&](std::string_view name) { return find(scan, name).has_value(); });
}

bool is_coordinate(std::string_view name) {
  return std::find(cartesian.begin(), cartesian.end(), name) != cartesian.end() ||
         std::find(spherical.begin(), spherical.end(), name) != spherical.end() || name == cartesian_state ||
         name == spherical_state;
}

AttributeType type_of(const E57Field& field) {
  using enum AttributeType;
  if (field.kind == E57Field::Kind::single) return f32;
  if (field.kind != E57Field::Kind::integer) return f64;
  if (field.minimum >= 0)
    return field.maximum <= UINT8_MAX    ? u8
           : field.maximum <= UINT16_MAX ? u16
           : field.maximum <= UINT32_MAX ? u32
                                         : i64;
  return field.minimum >= INT32_MIN && field.maximum <= INT32_MAX ? i32 : i64;
}

// Attributes have the usual names where there are such.
std::string_view usual_name(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> names{{{"colorRed", "red"},
                                                                                {"colorGreen", "green"},
                                                                                {"colorBlue", "blue"},
                                                                                {"rowIndex", "row_index"},
                                                                                {"columnIndex", "column_index"},
                                                                                {"returnIndex", "return_index"},
                                                                                {"returnCount", "return_count"},
                                                                                {"timeStamp", "time_stamp"}}};
  for (const auto& [stored, usual] : names)
    if (stored == name) return usual;
  return name;
}

// An attribute, and the field of that name in the scans that have it. An attribute without a field is the same for all
// points of a scan: value `of_scan` of values_of().
struct E57Attribute {
  Attribute attribute;
  std::string field;
  std::size_t of_scan = 0;
};

// The number of a scan, and where its scanner was, if the file says so.
std::array<double, 4> values_of(const E57Scan& scan) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const auto& [x, y, z] = scan.translation;
  const auto number = static_cast<double>(scan.number);
  return scan.posed ? std::array{number, x, y, z} : std::array{number, unknown, unknown, unknown};
}

// The attributes of all scans. A field whose type differs between scans becomes a double.
std::vector<E57Attribute> attributes_of(const E57Header& header) {
  std::vector<E57Attribute> found;
  AttributeNames names;
  for (const auto& scan : header.scans) {
    for (const auto& field : scan.fields) {
      if (is_coordinate(field.name) || field.kind == E57Field::Kind::text) continue;
      const auto known = std::find_if(found.begin(), found.end(), [&](const auto& a) { return a.field == field.name; });
      if (known == found.end())
        found.push_back({{names.make(usual_name(field.name)), type_of(field)}, field.name, 0});
      else if (known->attribute.type != type_of(field))
        known->attribute.type = AttributeType::f64;
    }
  }
  found.push_back({{names.make("scan"), AttributeType::u32}, "", 0});
  if (std::any_of(header.scans.begin(), header.scans.end(), [](const E57Scan& scan) { return scan.posed; }))
    for (std::size_t i = 0; i < scanner_position.size(); ++i)
      found.push_back({{names.make(scanner_position[i]), AttributeType::f64}, "", i + 1});
  return found;
}

// The motion of a scan: a rotation by a unit quaternion, then a translation.
class Pose {
 public:
  explicit Pose(const E57Scan& scan) : translation_(scan.translation) {
    const auto& [w, x, y, z] = scan.rotation;
    turns_ = x != 0 || y != 0 || z != 0;
    const double s = 2 / (w * w + x * x + y * y + z * z);
    rows_ = {{{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
              {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
              {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}}};
  }
  Point move(const Point& p) const {
    Point moved = p;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      if (turns_) moved[axis] = rows_[a][0] * p.x + rows_[a][1] * p.y + rows_[a][2] * p.z;
      moved[axis] += translation_[a];
    }
    return moved;
  }

 private:
  std::array<double, 3> translation_;
  bool turns_ = false;
  std::array<std::array<double, 3>, 3> rows_{};
};

// The streams of the fields that are wanted of one scan.
class ScanStream {
 public:
  ScanStream(E57Pages& pages, const E57Section& section, const E57Scan& scan)
      : pages_(&pages), section_(section), scan_(&scan), pose_(scan), spherical_(!has_all(scan, cartesian)) {
    const auto& names = spherical_ ? spherical : cartesian;
    for (const auto name : names) coordinates_.push_back(open(*find(scan, name)));
    if (const auto state = find(scan, spherical_ ? spherical_state : cartesian_state)) state_ = open(*state);
  }

  // A row gets the field `name`, if the scan has it, at `row_offset`, as `type`.
  void add(const std::string& name, std::size_t row_offset, AttributeType type) {
    const auto index = find(*scan_, name);
    if (!index) return;
    const bool integer = scan_->fields[*index].kind == E57Field::Kind::integer;
    cells_.push_back({open(*index), integer, row_offset,
                      column_copy(integer ? AttributeType::i64 : AttributeType::f64, false, type)});
  }

  // Appends the valid points of the next `n` records, and their rows, to the batch; `records` gets their numbers.
  Status read(std::size_t n, std::size_t row_bytes, PointBatch& batch, std::vector<std::uint64_t>& records) {
    std::array<std::vector<double>, 3> xyz;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      BOOST_OUTCOME_TRYV(coordinates_[axis].read(n, xyz[axis]));
    }
    std::vector<double> states(n, 0);
    if (state_) {
      BOOST_OUTCOME_TRYV(state_->read(n, states));
    }
    std::vector<std::byte> rows(n * row_bytes);
    for (auto& cell : cells_) {
      BOOST_OUTCOME_TRYV(read_cells(cell, n, row_bytes, rows));
    }
    for (std::size_t i = 0; i < n; ++i, ++position_) {
      if (states[i] != 0) continue;
      batch.points.push_back(pose_.move(point(xyz[0][i], xyz[1][i], xyz[2][i])));
      records.push_back(position_);
      const auto row = rows.begin() + static_cast<std::ptrdiff_t>(i * row_bytes);
      batch.rows.insert(batch.rows.end(), row, row + static_cast<std::ptrdiff_t>(row_bytes));
    }
    return success();
  }
  std::uint64_t left() const { return scan_->records - position_; }

 private:
  struct Cell {
    E57Stream stream;
    bool integer;
    std::size_t row_offset;
    ColumnCopy copy;
  };

  E57Stream open(std::size_t index) { return {*pages_, section_, scan_->fields[index], index, scan_->fields.size()}; }
  Point point(double a, double b, double c) const {
    if (!spherical_) return {a, b, c};
    return {a * std::cos(c) * std::cos(b), a * std::cos(c) * std::sin(b), a * std::sin(c)};
  }
  static Status read_cells(Cell& cell, std::size_t n, std::size_t row_bytes, std::vector<std::byte>& rows) {
    std::vector<std::int64_t> integers;
    std::vector<double> numbers;
    if (cell.integer) {
      BOOST_OUTCOME_TRYV(cell.stream.read(n, integers));
    } else {
      BOOST_OUTCOME_TRYV(cell.stream.read(n, numbers));
    }
    const void* from = cell.integer ? static_cast<const void*>(integers.data()) : numbers.data();
    cell.copy(static_cast<const std::byte*>(from), sizeof(double), rows.data() + cell.row_offset, row_bytes, n);
    return success();
  }

  E57Pages* pages_;
  E57Section section_;
  const E57Scan* scan_;
  Pose pose_;
  bool spherical_;
  std::vector<E57Stream> coordinates_;
  std::optional<E57Stream> state_;
  std::vector<Cell> cells_;
  std::uint64_t position_ = 0;
};

// A scan can only be passed over when all its records are points, because source indices count points.
bool is_passed_over(const E57Scan& scan, const std::vector<std::uint32_t>& wanted) {
  return !wanted.empty() && std::find(wanted.begin(), wanted.end(), scan.number) == wanted.end() &&
         !find(scan, cartesian_state) && !find(scan, spherical_state);
}

class E57Reader : public PointReader {
 public:
  E57Reader(FileInfo info, E57Pages pages, E57Header header, const std::vector<E57Attribute>& attributes,
            const std::vector<Attribute>& schema, std::vector<std::uint32_t> wanted)
      : info_(std::move(info)),
        pages_(std::move(pages)),
        header_(std::move(header)),
        wanted_(std::move(wanted)),
        row_bytes_(row_bytes(schema)) {
    const auto offsets = row_offsets(schema);
    for (std::size_t i = 0; i < schema.size(); ++i)
      for (const auto& attribute : attributes)
        if (attribute.attribute.name == schema[i].name)
          cells_.push_back({attribute.field, attribute.of_scan, offsets[i], schema[i].type});
  }

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    batch.points.clear();
    batch.rows.clear();
    batch.passed_over = 0;
    records_.clear();
    while (batch.points.empty()) {
      if (!stream_ || stream_->left() == 0) {
        if (next_scan_ == header_.scans.size()) return pages_.source().check_unchanged();
        if (const auto& scan = header_.scans[next_scan_]; is_passed_over(scan, wanted_)) {
          batch.passed_over += scan.records;
          ++next_scan_;
          continue;
        }
        BOOST_OUTCOME_TRYV(open_scan(next_scan_++));
      }
      constexpr std::size_t records_at_once = 8192;
      const auto n = static_cast<std::size_t>(
          std::min<std::uint64_t>(stream_->left(), std::min(records_at_once, points_at_once(most, row_bytes_))));
      BOOST_OUTCOME_TRYV(stream_->read(n, row_bytes_, batch, records_));
      for (const auto& cell : cells_)
        if (cell.field.empty()) write_scan(cell, batch);
    }
    return success();
  }

  Result<bool> seek(std::uint64_t) override { return false; }

  std::string place(std::size_t index) const override {
    return "scan " + std::to_string(header_.scans[next_scan_ - 1].number) + ", record " +
           std::to_string(index < records_.size() ? records_[index] : 0);
  }

 private:
  struct Cell {
    std::string field;
    std::size_t of_scan;  // when there is no field
    std::size_t row_offset;
    AttributeType type;
  };

  Status open_scan(std::size_t number) {
    const auto& scan = header_.scans[number];
    BOOST_OUTCOME_TRY(section, find_section(pages_, scan));
    stream_.emplace(pages_, section, scan);
    for (const auto& cell : cells_)
      if (!cell.field.empty()) stream_->add(cell.field, cell.row_offset, cell.type);
    return success();
  }

  void write_scan(const Cell& cell, PointBatch& batch) const {
    const double value = values_of(header_.scans[next_scan_ - 1])[cell.of_scan];
    column_copy(AttributeType::f64, false, cell.type)(reinterpret_cast<const std::byte*>(&value), 0,
                                                      batch.rows.data() + cell.row_offset, row_bytes_,
                                                      batch.points.size());
  }

  FileInfo info_;
  E57Pages pages_;
  E57Header header_;
  std::vector<std::uint32_t> wanted_;
  std::size_t row_bytes_;
  std::vector<Cell> cells_;
  std::size_t next_scan_ = 0;
  std::optional<ScanStream> stream_;
  std::vector<std::uint64_t> records_;  // of each point of the last batch
};

// Error bad_input when a scan has no coordinates, or a pose that is no motion.
Status check_scans(const E57Header& header, const std::string& path) {
  for (const auto& scan : header.scans) {
    const auto bad = [&](const char* what) {
      return error(Errc::bad_input, path + ": scan " + std::to_string(scan.number) + " " + what);
    };
    if (!has_all(scan, cartesian) && !has_all(scan, spherical))
      return bad("has neither cartesian nor spherical coordinates in 3D");
    double norm = 0;
    for (const double q : scan.rotation) norm += q * q;
    if (!(std::abs(norm - 1) < 1e-3)) return bad("has a pose whose rotation is not a unit quaternion");
  }
  return success();
}

}  // namespace

Result<std::unique_ptr<PointReader>> open_e57(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints) {
  FileInfo info = info_of(*source, "e57");
  BOOST_OUTCOME_TRY(page_bytes, e57_page_bytes(*source));
  E57Pages pages(std::move(source), page_bytes);
  BOOST_OUTCOME_TRY(header, read_e57_header(pages));
  // A scan without points may say anything.
  std::erase_if(header.scans, [](const E57Scan& scan) { return scan.records == 0; });
  if (header.scans.empty()) return error(Errc::bad_input, info.path.string() + ": holds no points");
  BOOST_OUTCOME_TRYV(check_scans(header, info.path.string()));
  info.detail = "E57, " + std::to_string(header.scans.size()) + (header.scans.size() == 1 ? " scan" : " scans");
  info.crs = header.crs;
  std::uint64_t points = 0, passed_over = 0;
  bool all_valid = true;
  for (const auto& scan : header.scans) {
    (is_passed_over(scan, hints.scans) ? passed_over : points) += scan.records;
    all_valid = all_valid && !find(scan, cartesian_state) && !find(scan, spherical_state);
  }
  if (all_valid) info.points = points;
  info.points_passed_over = passed_over;
  const auto found = attributes_of(header);
  for (const auto& attribute : found) info.attributes.push_back(attribute.attribute);
  return std::unique_ptr<PointReader>(
      new E57Reader(std::move(info), std::move(pages), std::move(header), found, attributes, hints.scans));
}

}  // namespace tessera
