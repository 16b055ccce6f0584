#include "src/io/cloud/point_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "src/base/option.h"
#include "src/io/bytes/fields.h"

namespace tessera {
namespace {

std::string coordinate(const Point& p, int dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    const double v = p[axis];
    if (std::isfinite(v)) continue;
    return std::string(1, "xyz"[axis]) + " is " + (std::isnan(v) ? "nan" : v > 0 ? "infinite" : "-infinite");
  }
  return "is not finite";
}

}  // namespace

PointFilter::PointFilter(const CloudOptions& options, const std::vector<Attribute>& schema)
    : options_(options), reader_schema_(schema), row_bytes_(row_bytes(schema)) {
  const auto offsets = row_offsets(schema);
  bool has_class = false;
  for (std::size_t i = 0; i < schema.size(); ++i) {
    if (schema[i].name == "z") z_at_ = offsets[i];
    if (schema[i].name != "classification") continue;
    has_class = true;
    class_at_ = offsets[i];
    class_type_ = schema[i].type;
  }
  if (!options.classes.empty() && !has_class) {
    class_at_ = row_bytes_;
    reader_schema_.push_back({"classification", AttributeType::u8});
  }
  reader_row_bytes_ = row_bytes(reader_schema_);
  keep_all_ = !options.crop && options.classes.empty();
}

bool PointFilter::is_valid(const Point& p) const {
  return std::isfinite(p.x) && std::isfinite(p.y) && (options_.dimension == 2 || std::isfinite(p.z));
}

bool PointFilter::is_wanted(const Point& p, const std::byte* row) const {
  if (options_.crop) {
    // Outside rather than not inside: in 2D, z may be NaN, and a box without z bounds must not mind.
    const auto& [lo, hi] = *options_.crop;
    if (p.x < lo.x || p.x > hi.x || p.y < lo.y || p.y > hi.y || p.z < lo.z || p.z > hi.z) return false;
  }
  if (options_.classes.empty()) return true;
  double value = 0;
  column_copy(class_type_, false, AttributeType::f64)(row + class_at_, 0, reinterpret_cast<std::byte*>(&value), 0, 1);
  return std::any_of(options_.classes.begin(), options_.classes.end(), [&](int c) { return c == value; });
}

Status PointFilter::apply(const PointBatch& batch, const PointReader& reader, std::uint64_t first_id, CloudBatch& to,
                          CloudCounts& counts) const {
  const std::size_t n = batch.points.size();
  const std::size_t before = to.points.size();
  to.points.resize(before + n);
  to.rows.resize((before + n) * row_bytes_);
  std::size_t kept = before;
  for (std::size_t i = 0; i < n; ++i) {
    const Point& p = batch.points[i];
    if (!is_valid(p)) {
      if (!options_.skip_invalid)
        return error(Errc::bad_input, reader.info().path.string() + ", " + reader.place(i) + ": " +
                                          coordinate(p, options_.dimension) + " (" + option("skip-invalid", "true") +
                                          " drops such points and counts them)");
      ++counts.invalid;
      continue;
    }
    const std::byte* row = batch.rows.data() + i * reader_row_bytes_;
    if (!keep_all_ && !is_wanted(p, row)) {
      ++counts.filtered;
      continue;
    }
    const double z = options_.dimension == 2 ? 0 : p.z;
    to.points[kept] = {.at = without_negative_zero({p.x, p.y, z}), .id = PointId{first_id + i}};
    if (row_bytes_ > 0) {
      std::byte* to_row = to.rows.data() + kept * row_bytes_;
      std::memcpy(to_row, row, row_bytes_);
      const double height = p.z + 0.0;  // no -0, as in coordinates
      if (z_at_) std::memcpy(to_row + *z_at_, &height, sizeof height);
    }
    ++kept;
  }
  counts.read += n;
  to.points.resize(kept);
  to.rows.resize(kept * row_bytes_);
  return success();
}

}  // namespace tessera
