#include "src/result/region/question.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/result/region/region_mesh.h"
#include "src/tiling/affine_basis.h"
#include "src/tiling/budget/budget.h"

namespace tessera {

RegionQuestion::RegionQuestion(PointUnits& units, std::map<std::size_t, LoadedUnit>& loaded, UnitTree& tree,
                               int dimension, std::size_t row_bytes, EqualPoints equal, const Bounds& region,
                               RegionShape shape, const RegionLimits& limits, std::stop_token stop)
    : units_(units),
      loaded_(loaded),
      tree_(tree),
      row_bytes_(row_bytes),
      height_at_(equal.height_at),
      region_(region),
      shape_(std::move(shape)),
      limits_(limits),
      stop_(std::move(stop)),
      triangulation_(dimension, equal.keep) {}

Result<RegionCells> RegionQuestion::answer() {
  const int dimension = triangulation_.dimension();
  std::vector<std::size_t> next = first_units();
  std::size_t groping = 1;
  CellList cells;
  Judgement judgement;
  while (true) {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted; nothing is kept");
    Wanted wanted = within_limits(next);
    BOOST_OUTCOME_TRYV(add(wanted));
    const bool flat = triangulation_.rank() < dimension;
    if (flat && tree_.all_read())
      return error(Errc::bad_input,
                   "the points of all files: " + why_flat(triangulation_.points(), triangulation_.rank(), dimension));
    if (flat) {
      next = nearest_units(groping);
      groping *= 2;
    } else if (!wanted.units.empty()) {
      cells = triangulation_.cells();
      judgement = judge(triangulation_, cells, region_, shape_, tree_, stop_);
      next = judgement.units;
      if (judgement.complete()) return finished(cells, judgement);
    }
    if (wanted.beyond.empty()) continue;
    const std::string sentence = needed(wanted.beyond, next);
    if (flat || !limits_.partial) return error(Errc::memory, sentence);
    RegionCells answer = finished(cells, judgement);
    answer.complete = false;
    answer.needed = sentence;
    return answer;
  }
}

std::vector<std::size_t> RegionQuestion::first_units() const {
  std::vector<std::size_t> units;
  for (std::size_t i = 0; i < units_.list().size(); ++i)
    if (meets_region(units_.list()[i].bounds)) units.push_back(i);
  return units.empty() ? nearest_units(1) : units;
}

// A unit that is not read now is read later, if a cell depends on it.
bool RegionQuestion::meets_region(const Bounds& unit) const {
  if (!boxes_meet(unit, region_)) return false;
  if (!shape_ || !(unit.lo.x < unit.hi.x && unit.lo.y < unit.hi.y)) return true;
  const Point low{unit.lo.x, unit.lo.y, 0}, right{unit.hi.x, unit.lo.y, 0}, high{unit.hi.x, unit.hi.y, 0},
      left{unit.lo.x, unit.hi.y, 0};
  return shape_(std::array{low, right, high}) || shape_(std::array{low, high, left});
}

std::vector<std::size_t> RegionQuestion::nearest_units(std::size_t n) const {
  std::vector<std::size_t> units;
  for (std::size_t i = 0; i < units_.list().size(); ++i)
    if (tree_.is_unread(i)) units.push_back(i);
  n = std::min(n, units.size());
  std::partial_sort(units.begin(), units.begin() + static_cast<std::ptrdiff_t>(n), units.end(),
                    [&](auto a, auto b) { return std::pair(tree_.distance(a), a) < std::pair(tree_.distance(b), b); });
  units.resize(n);
  return units;
}

bool RegionQuestion::late() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count() > limits_.max_seconds;
}

RegionQuestion::Wanted RegionQuestion::within_limits(std::vector<std::size_t> units) const {
  Wanted wanted;
  std::sort(units.begin(), units.end(),
            [&](auto a, auto b) { return std::pair(tree_.distance(a), a) < std::pair(tree_.distance(b), b); });
  std::uint64_t points = figures_.points_used;
  for (const std::size_t unit : units) {
    points += units_.list()[unit].points;
    if (points > limits_.max_points) {
      wanted.beyond = option("max-points");
    } else if (budget::region_bytes(triangulation_.dimension(), points, row_bytes_) > limits_.memory_bytes) {
      wanted.beyond = option("memory");
    } else if (late()) {
      wanted.beyond = option("max-seconds");
    }
    if (!wanted.beyond.empty()) break;
    wanted.units.push_back(unit);
  }
  // Without the other units there is no answer, so nothing is read.
  if (!wanted.beyond.empty() && !limits_.partial) wanted.units.clear();
  return wanted;
}

Status RegionQuestion::add(Wanted& wanted) {
  if (wanted.units.empty()) return success();
  BOOST_OUTCOME_TRYV(load(wanted.units, wanted.beyond));
  if (wanted.units.empty()) return success();
  std::vector<LocalPoint> points;
  std::vector<double> heights;
  for (const std::size_t unit : wanted.units) {
    LoadedUnit& loaded = loaded_.at(unit);
    loaded.used = began_;
    points.insert(points.end(), loaded.points.begin(), loaded.points.end());
    add_heights(loaded, heights);
    tree_.take(unit);
    used_.push_back(unit);
    figures_.points_used += units_.list()[unit].points;
  }
  figures_.units_used = used_.size();
  ++figures_.rounds;
  triangulation_.add(std::move(points), std::move(heights), stop_);
  return success();
}

void RegionQuestion::add_heights(const LoadedUnit& unit, std::vector<double>& heights) const {
  if (!height_at_) return;
  for (std::size_t i = 0; i < unit.points.size(); ++i) {
    double height = 0;
    std::memcpy(&height, unit.rows.data() + i * row_bytes_ + *height_at_, sizeof height);
    heights.push_back(height);
  }
}

// Units come by ascending number, and each is complete when the next one comes.
Status RegionQuestion::load(std::vector<std::size_t>& units, std::string& beyond) {
  std::sort(units.begin(), units.end());
  std::vector<std::size_t> absent;
  for (const std::size_t unit : units)
    if (!loaded_.contains(unit)) absent.push_back(unit);
  std::map<std::size_t, LoadedUnit> read;
  for (const std::size_t unit : absent) read[unit];
  std::uint64_t done = figures_.points_used, needed = done;
  for (const std::size_t unit : units) needed += units_.list()[unit].points;
  bool is_late = false;
  std::size_t current = 0;
  const auto status = units_.read(absent, [&](std::size_t unit, CloudBatch& batch) -> Status {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted; nothing is kept");
    current = unit;
    is_late = late();
    if (is_late) return error(Errc::interrupted, "the time that the region may take is over");
    done += batch.points.size();
    if (limits_.progress) limits_.progress(done, needed);
    LoadedUnit& to = read[unit];
    to.points.insert(to.points.end(), batch.points.begin(), batch.points.end());
    to.rows.insert(to.rows.end(), batch.rows.begin(), batch.rows.end());
    return success();
  });
  if (is_late) {
    beyond = option("max-seconds");
    read.erase(read.lower_bound(current), read.end());
    std::erase_if(units, [&](std::size_t unit) { return !loaded_.contains(unit) && !read.contains(unit); });
  } else {
    BOOST_OUTCOME_TRYV(status);
  }
  for (auto& [unit, points] : read) {
    ++figures_.units_read;
    figures_.points_read += units_.list()[unit].points;
    loaded_.emplace(unit, std::move(points));
  }
  return success();
}

std::string RegionQuestion::needed(const std::string& beyond, const std::vector<std::size_t>& units) const {
  constexpr std::size_t named_max = 5;
  std::uint64_t points = 0;
  std::string names;
  std::size_t named = 0, missing = 0;
  for (const std::size_t unit : units) {
    if (!tree_.is_unread(unit)) continue;
    ++missing;
    points += units_.list()[unit].points;
    if (++named <= named_max) names += (named == 1 ? "" : "; ") + units_.name(unit);
  }
  if (named > named_max) names += "; and " + std::to_string(named - named_max) + " others";
  return "the region needs more than " + beyond + " allows: " + std::to_string(figures_.points_used) + " points of " +
         std::to_string(used_.size()) + " units are triangulated, and at least " + std::to_string(points) +
         " points of " + std::to_string(missing) + " more units are needed: " + names;
}

RegionCells RegionQuestion::finished(const CellList& cells, const Judgement& judgement) {
  RegionMesh part = region_mesh(triangulation_, cells, judgement, stop_);
  RegionCells answer;
  answer.mesh = std::move(part.mesh);
  answer.final = std::move(part.final);
  answer.rows = rows_of(answer.mesh.ids);
  answer.figures = figures_;
  answer.figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  return answer;
}

// `ids` are ascending.
std::vector<std::byte> RegionQuestion::rows_of(const std::vector<PointId>& ids) const {
  std::vector<std::byte> rows(ids.size() * row_bytes_);
  if (row_bytes_ == 0) return rows;
  StopCheck check(stop_, 1 << 14);
  for (const std::size_t unit : used_) {
    const LoadedUnit& from = loaded_.at(unit);
    for (std::size_t i = 0; i < from.points.size(); ++i) {
      check.step();
      const auto found = std::lower_bound(ids.begin(), ids.end(), from.points[i].id);
      if (found == ids.end() || *found != from.points[i].id) continue;
      std::memcpy(rows.data() + static_cast<std::size_t>(found - ids.begin()) * row_bytes_,
                  from.rows.data() + i * row_bytes_, row_bytes_);
    }
  }
  return rows;
}

}  // namespace tessera
