#include "src/job/describe_points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

// Measures how much of a box holds points, on a raster of at most a million pixels with some ten points each.
class Area {
 public:
  Area(const Bounds& box, std::uint64_t points) {
    const double dx = box.hi.x - box.lo.x, dy = box.hi.y - box.lo.y;
    if (box.empty() || !(dx * dy > 0) || !std::isfinite(dx * dy)) return;
    const double pixels = std::clamp(static_cast<double>(points) / 10, 1.0, 1e6);
    side_ = std::sqrt(dx * dy / pixels);
    lo_ = box.lo;
    columns_ = static_cast<std::size_t>(dx / side_) + 1;
    rows_ = static_cast<std::size_t>(dy / side_) + 1;
    if (columns_ > 4'000'000 / rows_) return;  // the points lie on a line
    held_.resize(columns_ * rows_);
  }

  void add(const Point& p) {
    if (held_.empty()) return;
    const auto column = static_cast<std::size_t>(std::max(0.0, (p.x - lo_.x) / side_));
    const auto row = static_cast<std::size_t>(std::max(0.0, (p.y - lo_.y) / side_));
    if (column < columns_ && row < rows_) held_[row * columns_ + column] = true;
  }

  double value() const { return static_cast<double>(std::count(held_.begin(), held_.end(), true)) * side_ * side_; }

 private:
  Point lo_{};
  double side_ = 0;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<bool> held_;
};

using Histogram = std::map<std::int64_t, std::uint64_t>;

struct Column {
  std::string name;
  std::size_t at;
  AttributeType type;
  Histogram histogram = {};

  std::int64_t value(const std::byte* row) const {
    std::int64_t value = 0;
    column_copy(type, false, AttributeType::i64)(row + at, 0, reinterpret_cast<std::byte*>(&value), 0, 1);
    return value;
  }
};

Json to_json(const Histogram& histogram) {
  Json json = Json::object();
  for (const auto& [value, count] : histogram) json[std::to_string(value)] = count;
  return json;
}

}  // namespace

std::vector<std::string> described_attributes(const Cloud& cloud) {
  std::vector<std::string> wanted{"classification", "return_number", "number_of_returns"}, there;
  wanted.insert(wanted.end(), point_flags.begin(), point_flags.end());
  for (const auto& name : wanted) {
    const auto has = [&](const FileInfo& file) {
      return std::any_of(file.attributes.begin(), file.attributes.end(), [&](auto& a) { return a.name == name; });
    };
    if (std::any_of(cloud.files().begin(), cloud.files().end(), has)) there.push_back(name);
  }
  return there;
}

Result<Json> describe_points(const Cloud& cloud) {
  std::vector<Column> columns;
  std::size_t stride = 0;
  for (const auto& attribute : cloud.schema()) {
    if (attribute.name != "z") columns.push_back({attribute.name, stride, attribute.type});
    stride += size_of(attribute.type);
  }
  std::uint64_t expected = 0;
  Bounds declared;
  for (const auto& file : cloud.files()) {
    expected += file.points.value_or(file.content_bytes / 32);
    if (file.bounds) declared.add(*file.bounds);
  }
  Bounds box;
  Area area(declared, expected);
  BOOST_OUTCOME_TRY(counts, cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    for (std::size_t i = 0; i < batch.points.size(); ++i) {
      box.add(batch.points[i].at);
      area.add(batch.points[i].at);
      for (std::size_t c = 0; c < columns.size(); ++c)
        ++columns[c].histogram[columns[c].value(batch.rows.data() + i * stride)];
    }
    return success();
  }));
  const std::uint64_t kept = counts.read - counts.invalid - counts.filtered;
  Json described{{"points", counts.read}, {"invalid", counts.invalid}, {"filtered", counts.filtered}};
  if (!box.empty())
    described["bounds"] = {{"min", {box.lo.x, box.lo.y, box.lo.z}}, {"max", {box.hi.x, box.hi.y, box.hi.z}}};
  if (const double covered = area.value(); covered > 0 && kept > 0) {
    const double density = static_cast<double>(kept) / covered;
    described["covered_area"] = covered;
    described["density"] = density;
    described["spacing"] = std::sqrt(1 / density);
  }
  for (const auto& column : columns) described[column.name] = to_json(column.histogram);
  return described;
}

}  // namespace tessera
