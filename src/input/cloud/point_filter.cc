#include "src/input/cloud/point_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "src/base/option.h"
#include "src/input/bytes/fields.h"

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

std::vector<std::pair<std::string, const char*>> filtered_by(const CloudOptions& options) {
  std::vector<std::pair<std::string, const char*>> names;
  if (!options.classes.empty()) names.emplace_back("classification", "class");
  if (!options.scans.empty()) names.emplace_back("scan", "scan");
  if (!options.particles.empty()) names.emplace_back("particle_type", "particles");
  if (options.returns == Returns::first || options.returns == Returns::last)
    names.emplace_back("return_number", "returns");
  if (options.returns == Returns::last || options.returns == Returns::single)
    names.emplace_back("number_of_returns", "returns");
  for (const auto& flag : options.without) names.emplace_back(flag, "without");
  return names;
}

PointFilter::PointFilter(const CloudOptions& options, const std::vector<Attribute>& schema)
    : options_(options), reader_schema_(schema), row_bytes_(row_bytes(schema)), box_(options.period) {
  const auto offsets = row_offsets(schema);
  for (std::size_t i = 0; i < schema.size(); ++i) {
    if (schema[i].name == "z") z_at_ = offsets[i];
  }
  for (const auto& [name, key] : filtered_by(options)) {
    const Column found = column(name, name == "scan" ? AttributeType::u32 : AttributeType::u8);
    if (name == "classification") {
      class_ = found;
    } else if (name == "scan") {
      scan_ = found;
    } else if (name == "particle_type") {
      particle_type_ = found;
    } else if (name == "return_number") {
      number_ = found;
    } else if (name == "number_of_returns") {
      of_ = found;
    } else {
      flags_.push_back(found);
    }
  }
  reader_row_bytes_ = row_bytes(reader_schema_);
}

PointFilter::Column PointFilter::column(const std::string& name, AttributeType type) {
  const auto offsets = row_offsets(reader_schema_);
  for (std::size_t i = 0; i < reader_schema_.size(); ++i) {
    if (reader_schema_[i].name == name) return {offsets[i], reader_schema_[i].type};
  }
  const std::size_t at = row_bytes(reader_schema_);
  reader_schema_.push_back({name, type});
  return {at, type};
}

double PointFilter::Column::value(const std::byte* row) const {
  double value = 0;
  column_copy(type, false, AttributeType::f64)(row + at, 0, reinterpret_cast<std::byte*>(&value), 0, 1);
  return value;
}

bool PointFilter::is_valid(const Point& p) const {
  return std::isfinite(p.x) && std::isfinite(p.y) && (options_.dimension == 2 || std::isfinite(p.z));
}

bool PointFilter::is_in_box(const Point& p) const {
  if (!options_.crop) return true;
  // The test is "outside", not "not inside": in 2D z may be NaN, which a box without bounds in z must accept.
  const auto& [lo, hi] = *options_.crop;
  return !(p.x < lo.x || p.x > hi.x || p.y < lo.y || p.y > hi.y || p.z < lo.z || p.z > hi.z);
}

bool PointFilter::is_wanted(const std::byte* row, CloudCounts& counts) const {
  if (!options_.classes.empty()) {
    const double value = class_.value(row);
    if (std::none_of(options_.classes.begin(), options_.classes.end(), [&](int c) { return c == value; })) {
      if (value >= 0 && value < 256) counts.other_classes.set(static_cast<std::size_t>(value));
      return false;
    }
  }
  const auto is_one_of = [&](const std::vector<std::uint32_t>& wanted, const Column& column) {
    if (wanted.empty()) return true;
    const double value = column.value(row);
    return std::any_of(wanted.begin(), wanted.end(), [&](std::uint32_t w) { return w == value; });
  };
  if (!is_one_of(options_.scans, scan_) || !is_one_of(options_.particles, particle_type_)) return false;
  switch (options_.returns) {
    case Returns::all:
      break;
    case Returns::first:
      if (number_.value(row) != 1) return false;
      break;
    case Returns::last:
      if (number_.value(row) != of_.value(row)) return false;
      break;
    case Returns::single:
      if (of_.value(row) != 1) return false;
  }
  return std::all_of(flags_.begin(), flags_.end(), [&](const Column& flag) { return flag.value(row) == 0; });
}

std::string PointFilter::move(Point& p, CloudCounts& counts) const {
  const Point before = p;
  for (int axis = 0; axis < options_.dimension; ++axis) {
    if (!options_.period.along(axis)) continue;
    if (box_.is_far(p[axis], axis))
      return std::string(1, "xyz"[axis]) + " is more than 10^12 periods from the box, which leaves no digits within it";
    const auto [to, change] = box_.moved(p[axis], axis);
    if (change > 0 && !options_.snap)
      return std::string(1, "xyz"[axis]) + " has too many binary digits for images that are not rounded (" +
             option("periodic-snap", "yes") + " rounds it)";
    counts.snapped = std::max(counts.snapped, change);
    p[axis] = to;
  }
  counts.unmoved.add(before);
  // Rounding alone is less than half of the period.
  bool moved = false;
  for (int axis = 0; axis < options_.dimension; ++axis) {
    moved |= options_.period.along(axis) &&
             std::abs(p[axis] - before[axis]) > options_.period.length[static_cast<std::size_t>(axis)] / 2;
  }
  counts.moved += moved ? 1 : 0;
  return "";
}

Status PointFilter::apply(const PointBatch& batch, const PointReader& reader, std::uint64_t first_id, CloudBatch& to,
                          CloudCounts& counts) const {
  const std::size_t n = batch.points.size();
  const std::size_t before = to.points.size();
  to.points.resize(before + n);
  to.rows.resize((before + n) * row_bytes_);
  std::size_t kept = before;
  const bool periodic = options_.period.any();
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
    if (!is_in_box(p)) {
      ++counts.filtered;
      counts.outside.add(p);
      continue;
    }
    if (!is_wanted(row, counts)) {
      ++counts.filtered;
      continue;
    }
    const double z = options_.dimension == 2 ? 0 : p.z;
    Point at = without_negative_zero({p.x, p.y, z});
    if (periodic) {
      if (const auto reason = move(at, counts); !reason.empty())
        return error(Errc::bad_input, reader.info().path.string() + ", " + reader.place(i) + ": " + reason);
    }
    to.points[kept] = {.at = at, .id = PointId{first_id + i}};
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
