#include "src/input/cloud/cloud_units.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "src/base/option.h"
#include "src/input/ept/ept_known.h"
#include "src/input/laz/copc_units.h"

namespace tessera {
namespace {

// The rounding error relative to a coordinate, in the header and in the points.
constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();

Bounds widened(Bounds bounds, const Point& step) {
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lo[axis] -= 2 * step[axis] + rounding * std::abs(bounds.lo[axis]);
    bounds.hi[axis] += 2 * step[axis] + rounding * std::abs(bounds.hi[axis]);
  }
  return bounds;
}

// Twelve digits are a tenth of a millimetre for metres on the earth.
std::string text_of(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 12).ptr};
}

std::string text_of(const Point& p, int dimension) {
  return "(" + text_of(p.x) + ", " + text_of(p.y) + (dimension == 3 ? ", " + text_of(p.z) : "") + ")";
}

}  // namespace

CloudUnits::CloudUnits(Cloud cloud) : cloud_(std::move(cloud)), filter_(cloud_.options(), cloud_.schema()) {}

Result<std::unique_ptr<CloudUnits>> CloudUnits::open(Cloud cloud, bool scan, const std::stop_token& stop) {
  std::unique_ptr<CloudUnits> units(new CloudUnits(std::move(cloud)));
  for (std::size_t file = 0; file < units->cloud_.files().size(); ++file) {
    BOOST_OUTCOME_TRYV(units->add_file(file, scan, stop));
  }
  if (units->cloud_.options().dimension == 2) {
    for (auto& unit : units->list_) unit.bounds.lo.z = unit.bounds.hi.z = 0;
  }
  return units;
}

Status CloudUnits::add_file(std::size_t file, bool scan, const std::stop_token& stop) {
  if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while the input files were opened");
  const FileInfo& info = cloud_.files()[file];
  const std::size_t begin = list_.size();
  first_ids_.push_back(points_);
  if (info.levels) {
    BOOST_OUTCOME_TRY(source, cloud_.source(file));
    const double resolution = cloud_.options().resolution;
    BOOST_OUTCOME_TRY(
        nodes, info.format == "ept" ? ept::read_parts(*source, resolution) : laz::read_copc_units(*source, resolution));
    for (const auto& node : nodes) {
      list_.push_back({node.points, node.bytes, node.bounds});
      ranges_.push_back({.file = file, .first = node.first, .begin = node.begin});
    }
  } else {
    const Bounds stated = info.bounds ? widened(*info.bounds, info.step) : Bounds{};
    list_.push_back({info.points.value_or(0), info.bytes, stated});
    ranges_.push_back({.file = file, .whole = true});
  }
  if (scan || (!info.levels && !(info.points && info.bounds))) {
    BOOST_OUTCOME_TRYV(scan_file(file, begin, stop));
  }
  // A file with levels has more points than those of the wanted levels.
  points_ += info.levels ? *info.points + info.points_passed_over : list_.back().points;
  // Units without points are removed.
  for (std::size_t i = list_.size(); i-- > begin;) {
    if (list_[i].points > 0 && list_[i].bounds.lo.x <= list_[i].bounds.hi.x) continue;
    list_.erase(list_.begin() + static_cast<std::ptrdiff_t>(i));
    ranges_.erase(ranges_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return success();
}

// Finds bounds and number of points for the units from `begin` on, by reading. Points that are not finite are ignored.
Status CloudUnits::scan_file(std::size_t file, std::size_t begin, const std::stop_token& stop) {
  for (std::size_t i = begin; i < list_.size(); ++i) {
    list_[i].bounds = {};
    ranges_[i].seen = true;
  }
  if (begin == list_.size()) return success();
  BOOST_OUTCOME_TRY(reader, cloud_.reopen_whole(file, {}, ReadHints{.threads = cloud_.options().threads}));
  bytes_read_ += cloud_.files()[file].bytes;
  PointBatch batch;
  std::uint64_t rank = 0;
  for (std::size_t unit = begin;;) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while the input files were read");
    BOOST_OUTCOME_TRYV(reader->next(batch));
    if (batch.points.empty()) break;
    for (const Point& p : batch.points) {
      if (!ranges_[unit].whole && unit + 1 < list_.size() && rank == ranges_[unit + 1].first) ++unit;
      const Point at = without_negative_zero({p.x, p.y, cloud_.options().dimension == 2 ? 0 : p.z});
      const bool here =
          ranges_[unit].whole || (rank >= ranges_[unit].first && rank - ranges_[unit].first < list_[unit].points);
      if (here && is_finite(at)) list_[unit].bounds.add(at);
      ++rank;
    }
  }
  if (ranges_[begin].whole) list_[begin].points = rank;
  return success();
}

Status CloudUnits::read(std::span<const std::size_t> units,
                        const std::function<Status(std::size_t, CloudBatch&)>& visit) {
  std::vector<std::size_t> order(units.begin(), units.end());
  std::sort(order.begin(), order.end());  // by file and place, so that each file is opened once
  for (std::size_t i = 0; i < order.size();) {
    const std::size_t file = ranges_[order[i]].file;
    BOOST_OUTCOME_TRY(
        reader, cloud_.reopen_whole(file, filter_.reader_schema(),
                                    ReadHints{.threads = ranges_[order[i]].whole ? cloud_.options().threads : 1}));
    for (std::size_t brought = i; i < order.size() && ranges_[order[i]].file == file; ++i) {
      if (i == brought) {
        const auto next = std::span<const std::size_t>(order).subspan(i).first(units_ahead(order, i));
        BOOST_OUTCOME_TRYV(bring(next));
        brought += next.size();
      }
      BOOST_OUTCOME_TRYV(read_unit(*reader, order[i], visit));
    }
    // At the end of a file readers check that it is still the file that was opened.
    BOOST_OUTCOME_TRY(sought, reader->seek(std::numeric_limits<std::uint64_t>::max()));
    PointBatch end;
    if (sought) {
      BOOST_OUTCOME_TRYV(reader->next(end, 1));
    }
  }
  return success();
}

// How many of the units from `begin` on are worth bringing at a time, if their file is far.
std::size_t CloudUnits::units_ahead(std::span<const std::size_t> units, std::size_t begin) const {
  constexpr std::uint64_t bytes_max = std::uint64_t{16} << 20;  // a quarter of the least that is kept
  std::uint64_t bytes = 0;
  std::size_t end = begin;
  while (end < units.size() && ranges_[units[end]].file == ranges_[units[begin]].file) {
    bytes += list_[units[end]].bytes;
    if (end > begin && bytes > bytes_max) break;
    ++end;
  }
  return end - begin;
}

// Fetches units of one file before they are read, if the file is far and not whole.
Status CloudUnits::bring(std::span<const std::size_t> units) const {
  std::vector<FilePart> nodes;
  for (const std::size_t unit : units) {
    const RecordRange& range = ranges_[unit];
    if (range.whole) return success();
    nodes.push_back({range.first, list_[unit].points, range.begin, list_[unit].bytes, list_[unit].bounds});
  }
  const std::size_t file = ranges_[units.front()].file;
  BOOST_OUTCOME_TRY(source, cloud_.source(file));
  if (cloud_.files()[file].format == "ept") return ept::bring_parts(*source, nodes);
  return laz::bring_copc_units(*source, filter_.reader_schema(), nodes);
}

Status CloudUnits::read_unit(PointReader& reader, std::size_t unit,
                             const std::function<Status(std::size_t, CloudBatch&)>& visit) {
  const RecordRange& range = ranges_[unit];
  if (range.first > 0 || !range.whole) {
    BOOST_OUTCOME_TRYV(reader.seek(range.first));
  }
  bytes_read_ += list_[unit].bytes;
  PointBatch batch;
  CloudBatch kept;
  CloudCounts counts;
  std::uint64_t rank = 0;
  while (range.whole || rank < list_[unit].points) {
    const std::uint64_t left = range.whole ? SIZE_MAX : list_[unit].points - rank;
    BOOST_OUTCOME_TRYV(reader.next(batch, static_cast<std::size_t>(left)));
    if (batch.points.empty()) break;
    kept.points.clear();
    kept.rows.clear();
    BOOST_OUTCOME_TRYV(filter_.apply(batch, reader, first_ids_[range.file] + range.first + rank, kept, counts));
    rank += batch.points.size();
    BOOST_OUTCOME_TRYV(check_inside(kept.points, unit));
    if (!kept.points.empty()) {
      BOOST_OUTCOME_TRYV(visit(unit, kept));
    }
  }
  if (rank == list_[unit].points) return success();
  return error(Errc::bad_input, cloud_.files()[range.file].path.string() +
                                    ": was changed by another program while it was read: it had " +
                                    std::to_string(list_[unit].points) + " points there, and has " +
                                    std::to_string(rank));
}

Status CloudUnits::check_inside(const std::vector<LocalPoint>& points, std::size_t unit) const {
  const int dimension = cloud_.options().dimension;
  const auto& [lo, hi] = list_[unit].bounds;
  for (const auto& p : points) {
    bool inside = true;
    for (int axis = 0; axis < dimension; ++axis) inside &= p.at[axis] >= lo[axis] && p.at[axis] <= hi[axis];
    if (inside) continue;
    const std::size_t file = ranges_[unit].file;
    const std::string path = cloud_.files()[file].path.string();
    const std::string record = ", record " + std::to_string(p.id.value - first_ids_[file]) + ": ";
    if (ranges_[unit].seen)
      return error(Errc::bad_input, path + record + "was changed by another program while it was read");
    return error(Errc::bad_input, path + record + text_of(p.at, dimension) +
                                      " lies outside the box that the file states for it, " + text_of(lo, dimension) +
                                      " to " + text_of(hi, dimension) + ", so the boxes in the file are wrong; " +
                                      option("scan-files", "true") +
                                      " reads all files once, and takes the boxes of their points instead");
  }
  return success();
}

std::string CloudUnits::name(std::size_t unit) const {
  const RecordRange& range = ranges_[unit];
  const int dimension = cloud_.options().dimension;
  std::string text = cloud_.files()[range.file].path.string();
  if (!range.whole) {
    text += ", records " + std::to_string(range.first) + " to " + std::to_string(range.first + list_[unit].points - 1);
  }
  const auto& [lo, hi] = list_[unit].bounds;
  return text + ", in " + text_of(lo, dimension) + " to " + text_of(hi, dimension);
}

}  // namespace tessera
