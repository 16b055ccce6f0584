#include "src/input/fits/fits_reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/column_names.h"
#include "src/input/cosmology.h"
#include "src/input/fits/fits_header.h"
#include "src/input/fits/fits_table.h"
#include "src/input/fits/sky.h"

namespace tessera::fits {
namespace {

// A number of each row, and the attribute that it is.
struct FitsAttribute {
  Attribute attribute;
  Element from;
};

// Numbers of rows as they mean, not as they are stored.
class Numbers {
 public:
  Numbers(const NumberColumn& column, std::size_t element)
      : column_(column), at_(column.offset + element * size_of(column.stored)) {}

  // Writes the numbers of `n` rows as type `to`.
  void copy(const std::byte* rows, std::size_t row_bytes, std::size_t n, AttributeType type, std::byte* to,
            std::size_t stride) {
    const bool plain = !column_.scale && !column_.null && !column_.other_sign && !column_.logical;
    if (plain) {
      column_copy(column_.stored, true, type)(rows + at_, row_bytes, to, stride, n);
    } else if (column_.stored == AttributeType::i64 && !column_.scale) {
      copy_whole(rows, row_bytes, n);
      column_copy(column_.type(), false, type)(reinterpret_cast<const std::byte*>(whole_.data()), sizeof(std::uint64_t),
                                               to, stride, n);
    } else {
      copy_doubles(rows, row_bytes, n);
      column_copy(AttributeType::f64, false, type)(reinterpret_cast<const std::byte*>(real_.data()), sizeof(double), to,
                                                   stride, n);
    }
  }

 private:
  // Integers of 64 bits, which doubles would round.
  void copy_whole(const std::byte* rows, std::size_t row_bytes, std::size_t n) {
    whole_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint64_t stored = __builtin_bswap64(load<std::uint64_t>(rows + at_ + i * row_bytes));
      const bool missing = column_.null == static_cast<std::int64_t>(stored);
      whole_[i] = missing ? 0 : column_.other_sign ? stored ^ (std::uint64_t{1} << 63) : stored;
    }
  }

  void copy_doubles(const std::byte* rows, std::size_t row_bytes, std::size_t n) {
    real_.resize(n);
    column_copy(column_.stored, true, AttributeType::f64)(
        rows + at_, row_bytes, reinterpret_cast<std::byte*>(real_.data()), sizeof(double), n);
    if (column_.null) missing_.resize(n);
    if (column_.null)
      column_copy(column_.stored, true, AttributeType::i64)(
          rows + at_, row_bytes, reinterpret_cast<std::byte*>(missing_.data()), sizeof(std::int64_t), n);
    const double half = std::ldexp(1.0, static_cast<int>(8 * size_of(column_.stored)) - 1);
    const double shift = !column_.other_sign ? 0 : column_.stored == AttributeType::u8 ? -half : half;
    for (std::size_t i = 0; i < n; ++i) {
      double& value = real_[i];
      if (column_.logical) value = value == 'T' ? 1 : 0;
      if (column_.scale) value = column_.zero + *column_.scale * value;
      value += shift;
      if (column_.null && missing_[i] == *column_.null) value = std::numeric_limits<double>::quiet_NaN();
    }
  }

  NumberColumn column_;
  std::size_t at_;
  std::vector<double> real_;
  std::vector<std::int64_t> missing_;
  std::vector<std::uint64_t> whole_;
};

class FitsReader : public PointReader {
 public:
  FitsReader(FileInfo info, RecordStream records, const Table& table, const Places& places,
             const std::vector<FitsAttribute>& attributes, const std::vector<Attribute>& schema,
             const std::optional<Cosmology>& cosmology)
      : info_(std::move(info)), records_(std::move(records)), of_(places.of), row_bytes_(row_bytes(schema)) {
    for (const Element& from : places.elements) coordinates_.emplace_back(table.columns[from.column], from.element);
    if (cosmology) distance_.emplace(*cosmology);
    const auto offsets = row_offsets(schema);
    for (const auto& attribute : attributes)
      for (std::size_t i = 0; i < schema.size(); ++i)
        if (attribute.attribute.name == schema[i].name)
          values_.push_back(
              {Numbers(table.columns[attribute.from.column], attribute.from.element), offsets[i], schema[i].type});
  }

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    BOOST_OUTCOME_TRY(block, records_.next(points_at_once(most, row_bytes_)));
    const std::size_t stride = records_.record_bytes(), n = block.size() / stride;
    batch.points.assign(n, Point{});
    batch.rows.assign(n * row_bytes_, std::byte{0});
    if (n == 0) return success();
    auto* points = reinterpret_cast<std::byte*>(batch.points.data());
    for (std::size_t axis = 0; axis < coordinates_.size(); ++axis)
      coordinates_[axis].copy(block.data(), stride, n, AttributeType::f64, points + axis * sizeof(double),
                              sizeof(Point));
    for (auto& value : values_)
      value.numbers.copy(block.data(), stride, n, value.type, batch.rows.data() + value.at, row_bytes_);
    if (of_ != Places::Of::xyz) {
      on_sky_ = batch.points;
      for (Point& p : batch.points) p = place_on_sky(p.x, p.y, of_ == Places::Of::redshift ? (*distance_)(p.z) : p.z);
    }
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    records_.seek(index);
    return true;
  }

  // For a point that has no place, also why.
  std::string place(std::size_t index) const override {
    const std::string row = "row " + std::to_string(records_.first_of_last_block() + index);
    if (of_ == Places::Of::xyz) return row;
    const Point& p = on_sky_[index];
    const auto is = [&](const char* what, double value) { return row + ", whose " + what + " is " + text_of(value); };
    if (!std::isfinite(p.x)) return is("right ascension", p.x);
    if (!(p.y >= -90 && p.y <= 90)) return is("declination", p.y);
    const double most = of_ == Places::Of::redshift ? ComovingDistance::greatest_redshift : HUGE_VAL;
    if (!(p.z >= 0 && p.z <= most) || std::isinf(p.z))
      return is(of_ == Places::Of::redshift ? "redshift" : "distance", p.z);
    return row;
  }

 private:
  struct Value {
    Numbers numbers;
    std::size_t at;
    AttributeType type;
  };

  static std::string text_of(double value) {
    std::array<char, 32> text{};
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
  }

  FileInfo info_;
  RecordStream records_;
  Places::Of of_;
  std::size_t row_bytes_;
  std::vector<Numbers> coordinates_;
  std::optional<ComovingDistance> distance_;
  std::vector<Value> values_;
  std::vector<Point> on_sky_;  // of the last batch: right ascension, declination, and distance or redshift
};

// Whether `hdu` is what the option names: a number, or a name in either case.
bool is_named(const Hdu& hdu, const std::string& wanted) {
  if (wanted == std::to_string(hdu.number)) return true;
  const std::string name = hdu.name();
  return std::equal(name.begin(), name.end(), wanted.begin(), wanted.end(),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

Result<Hdu> find_table(const ByteSource& source, const std::string& wanted) {
  const auto refuse = [&](Errc code, const std::string& what) {
    return error(code, source.path().string() + ": " + what);
  };
  Hdus hdus(source);
  std::string tables;
  bool compressed = false, text = false;
  constexpr std::size_t listed_max = 20;
  for (std::size_t listed = 0;;) {
    BOOST_OUTCOME_TRY(hdu, hdus.next());
    if (!hdu) break;
    const bool table = hdu->is_table();
    if (!wanted.empty() && is_named(*hdu, wanted)) {
      if (table) return std::move(*hdu);
      return refuse(Errc::usage, hdu->title() + ", which " + option("hdu") + " names, is no binary table");
    }
    // Images that are packed into tables are none.
    if (table && wanted.empty() && !hdu->cards.is_true("ZIMAGE")) return std::move(*hdu);
    compressed = compressed || hdu->cards.is_true("ZIMAGE");
    text = text || hdu->cards.text("XTENSION") == "TABLE";
    if (table && listed++ < listed_max) tables += (tables.empty() ? "" : ", ") + hdu->title();
  }
  if (!wanted.empty())
    return refuse(Errc::usage,
                  "has no HDU " + in_quotes(wanted) + "; its tables are " + (tables.empty() ? "none" : tables));
  return refuse(Errc::bad_input,
                std::string("has no binary table") + (text         ? "; its table is in text, which is not read"
                                                      : compressed ? "; it holds compressed images"
                                                                   : "; it holds images alone"));
}

std::vector<FitsAttribute> attributes_of(const Table& table, const Places& places) {
  std::vector<FitsAttribute> found;
  AttributeNames names;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const NumberColumn& column = table.columns[c];
    const bool is_coordinate =
        places.of == Places::Of::xyz && std::any_of(places.elements.begin(), places.elements.end(),
                                                    [&](const Element& element) { return element.column == c; });
    if (is_coordinate) continue;
    for (std::size_t e = 0; e < column.count; ++e) {
      const std::string name = column.count == 1 ? column.name : column.name + "_" + std::to_string(e + 1);
      found.push_back({{names.make(name), column.type(), column.unit}, {c, e}});
    }
  }
  return found;
}

// The unit of the coordinates; "" if columns have others.
std::string unit_of(const Table& table, const Places& places) {
  if (places.of == Places::Of::redshift) return "Mpc";
  const auto unit = [&](const Element& element) { return table.columns[element.column].unit; };
  if (places.of == Places::Of::distance) return unit(places.elements[2]);
  const std::string first = unit(places.elements[0]);
  const bool same = std::all_of(places.elements.begin(), places.elements.end(),
                                [&](const Element& element) { return unit(element) == first; });
  return same ? first : "";
}

std::string detail_of(const Table& table, const Places& places) {
  std::string names, left_out;
  for (std::size_t i = 0; i < places.elements.size(); ++i) {
    const Element& element = places.elements[i];
    const NumberColumn& column = table.columns[element.column];
    if (column.count > 1 && i > 0) break;
    names += (i == 0 ? "" : ", ") + printable(column.name);
  }
  for (const std::string& column : table.left_out) left_out += (left_out.empty() ? "" : ", ") + column;
  return "FITS, " + table.title + ", coordinates from " + names + (left_out.empty() ? "" : "; left out: " + left_out);
}

}  // namespace

Result<std::unique_ptr<PointReader>> open_fits(std::unique_ptr<ByteSource> source,
                                               const std::vector<Attribute>& attributes, const ReadHints& hints) {
  FileInfo info = info_of(*source, "fits");
  const std::string path = info.path.string();
  BOOST_OUTCOME_TRY(hdu, find_table(*source, hints.hdu));
  BOOST_OUTCOME_TRY(table, table_of(hdu, path));
  const auto named = are_entries(hints.columns) ? hints.columns : std::vector<std::string>{};
  BOOST_OUTCOME_TRY(places, places_of(table, named, hints.cosmology.has_value(), path));
  info.redshifts = places.of == Places::Of::redshift;
  if (info.redshifts && !hints.cosmology)
    return error(Errc::usage, path + ": " + table.title + " places its points by the redshift " +
                                  in_quotes(table.columns[places.elements[2].column].name) +
                                  ", which is a distance in a cosmology alone; state a flat one by " +
                                  option("cosmology") + ": H0 in km/s/Mpc, and the density of matter, as 70,0.3");
  info.detail = detail_of(table, places);
  info.dimension = places.elements.size() == 2 ? 2 : 3;
  info.points = table.rows;
  info.unit = unit_of(table, places);
  const auto found = attributes_of(table, places);
  for (const auto& attribute : found) info.attributes.push_back(attribute.attribute);
  RecordStream records(std::move(source), table.data_at, table.row_bytes, table.rows);
  BOOST_OUTCOME_TRYV(records.check_size());
  const auto cosmology = info.redshifts ? hints.cosmology : std::nullopt;
  return std::unique_ptr<PointReader>(
      new FitsReader(std::move(info), std::move(records), table, places, found, attributes, cosmology));
}

}  // namespace tessera::fits
