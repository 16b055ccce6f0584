#include "src/result/voids/void_files.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <numeric>

#include "src/base/files/disk_file.h"
#include "src/base/files/there.h"
#include "src/base/files/voids_names.h"
#include "src/result/export/ending.h"
#include "src/result/measure/scaled_double.h"

namespace tessera::voids {

namespace fs = std::filesystem;

namespace {

// A line of text whose numbers have the shortest digits that are read back as the same.
class Line {
 public:
  template <class Number>
  Line& add(Number number) {
    std::array<char, 40> digits{};
    text_.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
    return *this;
  }
  Line& add(const char* text) {
    text_ += text;
    return *this;
  }
  Line& add(char one) {
    text_ += one;
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// The greatest contrast first; of equal ones the zone with the lower number.
std::vector<ZoneNumber> by_contrast(const VoidTable& table) {
  std::vector<ZoneNumber> order(table.rows.size());
  std::iota(order.begin(), order.end(), ZoneNumber{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](ZoneNumber a, ZoneNumber b) { return table.rows[a].contrast > table.rows[b].contrast; });
  return order;
}

Status write_csv(OutputFile& file, const VoidTable& table) {
  const bool flat = table.dimension == 2;
  const std::string size = flat ? "area" : "volume";
  BOOST_OUTCOME_TRYV(file.append("zone,core_density,x,y," + std::string(flat ? "" : "z,") + "zone_points,zone_" + size +
                                 ",saddle_vertex,saddle_density,parent,void_zones,void_points,void_" + size +
                                 ",contrast,probability\n"));
  for (const ZoneNumber zone : by_contrast(table)) {
    const VoidRow& row = table.rows[zone];
    Line line;
    line.add(row.core.value).add(',').add(row.core_density).add(',').add(row.place.x).add(',').add(row.place.y);
    if (!flat) line.add(',').add(row.place.z);
    line.add(',').add(row.zone_points).add(',').add(row.zone_volume).add(',');
    if (row.saddle) line.add(row.saddle->value);
    line.add(',').add(row.saddle_density).add(',');
    if (row.parent != no_zone) line.add(table.rows[row.parent].core.value);
    line.add(',').add(row.zones).add(',').add(row.points).add(',').add(row.volume);
    line.add(',').add(row.contrast).add(',').add(row.probability).add('\n');
    BOOST_OUTCOME_TRYV(file.append(line.text()));
  }
  return success();
}

std::string with_six_digits(double value, const char* format) {
  std::array<char, 40> digits{};
  std::snprintf(digits.data(), digits.size(), format, value);
  return digits.data();
}

// The mean volume of the Voronoi cells of the points in zones.
double mean_volume(const VoidTable& table) {
  OrderFreeSum sum;
  std::uint64_t points = 0;
  for (const VoidRow& row : table.rows) {
    sum.add(ScaledDouble::of(row.zone_volume));
    points += row.zone_points;
  }
  return points == 0 ? 1 : (sum.value() / ScaledDouble::of(static_cast<double>(points))).value();
}

Status write_list(OutputFile& file, const VoidTable& table, std::uint64_t points) {
  const double mean = mean_volume(table);
  BOOST_OUTCOME_TRYV(file.append(Line().add(points).add(" particles, ").add(table.rows.size()).add(" voids\n").text()));
  BOOST_OUTCOME_TRYV(
      file.append("Void# FileVoid# CoreParticle CoreDens ZoneVol Zone#Part Void#Zones VoidVol Void#Part "
                  "VoidDensContrast VoidProb\n"));
  std::uint64_t rank = 0;
  for (const ZoneNumber zone : by_contrast(table)) {
    const VoidRow& row = table.rows[zone];
    Line line;
    line.add(++rank).add(' ').add(zone).add(' ').add(row.core.value).add(' ');
    line.add(with_six_digits(row.core_density * mean, "%e").c_str()).add(' ');
    line.add(with_six_digits(row.zone_volume / mean, "%e").c_str()).add(' ');
    line.add(row.zone_points).add(' ').add(row.zones).add(' ');
    line.add(with_six_digits(row.volume / mean, "%e").c_str()).add(' ').add(row.points).add(' ');
    line.add(with_six_digits(row.contrast, "%f").c_str()).add(' ');
    line.add(with_six_digits(row.probability, "%6.2e").c_str()).add('\n');
    BOOST_OUTCOME_TRYV(file.append(line.text()));
  }
  return success();
}

// The zones that flow out to each zone, by the level of their saddle.
class Hierarchy {
 public:
  explicit Hierarchy(const VoidTable& table) : rows_(table.rows), first_(table.rows.size() + 1, 0) {
    for (const VoidRow& row : rows_)
      if (row.parent != no_zone) ++first_[row.parent + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    children_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (ZoneNumber zone = 0; zone < rows_.size(); ++zone)
      if (rows_[zone].parent != no_zone) children_[next[rows_[zone].parent]++] = zone;
    for (ZoneNumber zone = 0; zone < rows_.size(); ++zone) {
      const auto own = std::span(children_).subspan(first_[zone], first_[zone + 1] - first_[zone]);
      std::stable_sort(own.begin(), own.end(), [&](ZoneNumber a, ZoneNumber b) { return is_lower(a, b); });
    }
  }

  std::span<const ZoneNumber> children(ZoneNumber zone) const {
    return std::span(children_).subspan(first_[zone], first_[zone + 1] - first_[zone]);
  }
  bool same_saddle(ZoneNumber a, ZoneNumber b) const { return rows_[a].saddle == rows_[b].saddle; }

  // All zones of the void of `zone`, ascending.
  std::vector<ZoneNumber> zones_of(ZoneNumber zone) const {
    std::vector<ZoneNumber> all{zone};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto more = children(all[i]);
      all.insert(all.end(), more.begin(), more.end());
    }
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  bool is_lower(ZoneNumber a, ZoneNumber b) const {
    return rows_[a].saddle_density != rows_[b].saddle_density ? rows_[a].saddle_density < rows_[b].saddle_density
                                                              : rows_[a].saddle < rows_[b].saddle;
  }
  const std::vector<VoidRow>& rows_;
  std::vector<std::size_t> first_;
  std::vector<ZoneNumber> children_;
};

Status write_hierarchy(OutputFile& file, const VoidTable& table) {
  const Hierarchy hierarchy(table);
  BOOST_OUTCOME_TRYV(file.append(Line().add(table.rows.size()).add('\n').text()));
  for (ZoneNumber zone = 0; zone < table.rows.size(); ++zone) {
    Line line;
    line.add(zone);
    const auto children = hierarchy.children(zone);
    for (std::size_t begin = 0, end = 0; begin < children.size(); begin = end) {
      std::vector<ZoneNumber> added;
      for (; end < children.size() && hierarchy.same_saddle(children[begin], children[end]); ++end) {
        const auto more = hierarchy.zones_of(children[end]);
        added.insert(added.end(), more.begin(), more.end());
      }
      std::sort(added.begin(), added.end());
      const double ratio = table.rows[children[begin]].saddle_density / table.rows[zone].core_density;
      line.add(' ').add(added.size()).add(' ').add(ratio);
      for (const ZoneNumber one : added) line.add(' ').add(one);
    }
    line.add(" 0 ").add(table.rows[zone].contrast).add('\n');
    BOOST_OUTCOME_TRYV(file.append(line.text()));
  }
  return success();
}

}  // namespace

std::vector<fs::path> files_of(const fs::path& target) {
  if (exports::ending_of(target) == ".csv") return {target};
  return {fs::path(target).replace_extension(".zone"), fs::path(target).replace_extension(".void"), target};
}

Status check_voids_target(const fs::path& target, bool overwrite) {
  const std::string ending = exports::ending_of(target);
  if (ending != ".csv" && ending != ".txt")
    return error(Errc::usage, target.string() + ": '" + ending +
                                  "' is not a format of voids; the formats are .csv, a table, and .txt, which writes "
                                  "the files .txt, .zone and .void of ZOBOV");
  for (const fs::path& file : files_of(target)) {
    BOOST_OUTCOME_TRYV(exports::check_free(file, overwrite));
  }
  return success();
}

ZonesByPoint::ZonesByPoint(fs::path scratch, std::vector<DuplicatePair> duplicates, std::uint64_t points)
    : scratch_(std::move(scratch)), duplicates_(std::move(duplicates)), points_(points) {
  std::sort(duplicates_.begin(), duplicates_.end(), [](const auto& a, const auto& b) { return a.kept < b.kept; });
}

Status ZonesByPoint::add(std::span<const PointId> vertices, std::span<const ZoneNumber> zones) {
  std::vector<Entry> entries;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    entries.push_back({vertices[v], zones[v]});
    const auto kept = std::ranges::equal_range(duplicates_, vertices[v], {}, &DuplicatePair::kept);
    for (const DuplicatePair& pair : kept) entries.push_back({pair.duplicate, zones[v]});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.point < b.point; });
  return append(std::move(entries));
}

Status ZonesByPoint::append(std::vector<Entry> entries) {
  const std::lock_guard lock(mutex_);
  if (!entries.empty()) points_ = std::max(points_, entries.back().point.value + 1);
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    const std::uint64_t number = entries[begin].point.value / points_a_file;
    while (end < entries.size() && entries[end].point.value / points_a_file == number) ++end;
    BOOST_OUTCOME_TRY(file, DiskFile::open(voids_zones_file(scratch_, number), DiskFile::Mode::append));
    BOOST_OUTCOME_TRYV(file.write(std::as_bytes(std::span(entries).subspan(begin, end - begin))));
    BOOST_OUTCOME_TRYV(file.close());
  }
  return success();
}

Status ZonesByPoint::write(OutputFile& file, std::size_t zones) const {
  BOOST_OUTCOME_TRYV(file.append(Line().add(points_).add(' ').add(zones).add('\n').text()));
  std::vector<ZoneNumber> of_points;
  std::vector<Entry> entries;
  for (std::uint64_t first = 0; first < points_; first += points_a_file) {
    of_points.assign(std::min(points_a_file, points_ - first), no_zone);
    const fs::path path = voids_zones_file(scratch_, first / points_a_file);
    BOOST_OUTCOME_TRY(there, is_there(path));
    if (there) {
      BOOST_OUTCOME_TRY(from, DiskFile::open(path, DiskFile::Mode::read));
      BOOST_OUTCOME_TRY(bytes, from.size());
      entries.resize(bytes / sizeof(Entry));
      BOOST_OUTCOME_TRY(read, from.read(std::as_writable_bytes(std::span(entries))));
      if (read != entries.size() * sizeof(Entry)) return error(Errc::io, path.string() + ": is shorter than it was");
      for (const Entry& entry : entries) of_points[entry.point.value - first] = entry.zone;
    }
    for (const ZoneNumber zone : of_points) {
      Line line;
      zone == no_zone ? line.add("-1") : line.add(zone);
      BOOST_OUTCOME_TRYV(file.append(line.add('\n').text()));
    }
  }
  return success();
}

Result<std::vector<OutputFile>> write_voids(const VoidTable& table, const fs::path& target,
                                            const ZonesByPoint* points) {
  std::vector<OutputFile> files;
  for (const fs::path& path : files_of(target)) {
    BOOST_OUTCOME_TRY(file, OutputFile::create(path));
    const std::string ending = exports::ending_of(path);
    if (ending == ".csv") {
      BOOST_OUTCOME_TRYV(write_csv(file, table));
    } else if (ending == ".zone") {
      BOOST_OUTCOME_TRYV(points->write(file, table.rows.size()));
    } else if (ending == ".void") {
      BOOST_OUTCOME_TRYV(write_hierarchy(file, table));
    } else {
      BOOST_OUTCOME_TRYV(write_list(file, table, points->points()));
    }
    files.push_back(std::move(file));
  }
  return files;
}

}  // namespace tessera::voids
