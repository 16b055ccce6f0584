#include "src/job/describe_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/io/bytes/fields.h"
#include "src/report/human.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

// Source: ASPRS, LAS Specification 1.4 - R15, table 17.
const char* class_name(int number) {
  constexpr std::array names{"never classified",
                             "unassigned",
                             "ground",
                             "low vegetation",
                             "medium vegetation",
                             "high vegetation",
                             "building",
                             "low point",
                             "model key point",
                             "water",
                             "rail",
                             "road",
                             "overlap",
                             "wire guard",
                             "wire conductor",
                             "transmission tower",
                             "wire connector",
                             "bridge deck",
                             "high noise",
                             "overhead structure",
                             "ignored ground",
                             "snow",
                             "temporal exclusion"};
  return number >= 0 && number < static_cast<int>(names.size()) ? names[static_cast<std::size_t>(number)]
         : number < 64                                          ? "reserved"
                                                                : "of the user";
}

// How much of a box holds points: a raster of at most a million pixels, some ten points each.
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
    if (columns_ > 4'000'000 / rows_) return;  // a line of points
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

std::string to_text(const Column& column) {
  std::string text;
  for (const auto& [value, count] : column.histogram) {
    text += (text.empty() ? "" : ", ") + std::to_string(value);
    if (column.name == "classification") text += std::string(" ") + class_name(static_cast<int>(value));
    text += ": " + grouped(count);
  }
  return text;
}

std::string label(const std::string& name) {
  if (name == "classification") return "classes";
  if (name == "return_number") return "returns";
  return name == "number_of_returns" ? "of returns" : name;
}

bool is_flag(const std::string& name) {
  return std::find(point_flags.begin(), point_flags.end(), name) != point_flags.end();
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

Result<DescribedPoints> describe_points(const Cloud& cloud) {
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
  DescribedPoints described;
  const std::uint64_t kept = counts.read - counts.invalid - counts.filtered;
  described.json = {{"points", counts.read}, {"invalid", counts.invalid}, {"filtered", counts.filtered}};
  const auto line = [&](std::string name, const std::string& value) {
    name.resize(12, ' ');
    described.text += "  " + name + value + "\n";
  };
  line("read", grouped(counts.read) + " points, " + grouped(counts.invalid) + " invalid, " + grouped(counts.filtered) +
                   " filtered out");
  if (!box.empty()) {
    described.json["bounds"] = {{"min", {box.lo.x, box.lo.y, box.lo.z}}, {"max", {box.hi.x, box.hi.y, box.hi.z}}};
    const auto side = [](double lo, double hi) { return coordinate(lo) + " .. " + coordinate(hi); };
    line("box", side(box.lo.x, box.hi.x) + "   " + side(box.lo.y, box.hi.y) + "   " + side(box.lo.z, box.hi.z));
  }
  if (const double covered = area.value(); covered > 0 && kept > 0) {
    const double density = static_cast<double>(kept) / covered;
    described.json["covered_area"] = covered;
    described.json["density"] = density;
    described.json["spacing"] = std::sqrt(1 / density);
    line("density", coordinate(std::round(density * 1000) / 1000) + " points a square unit where there are any, " +
                        fixed(std::sqrt(1 / density), 3) + " apart");
  }
  for (const auto& column : columns) {
    described.json[column.name] = to_json(column.histogram);
    const bool none = is_flag(column.name) && column.histogram.size() == 1 && column.histogram.begin()->first == 0;
    if (!none) line(label(column.name), to_text(column));
  }
  return described;
}

}  // namespace tessera
