#include "src/result/region/regions.h"

#include <algorithm>
#include <new>
#include <utility>

#include "src/base/stopped.h"
#include "src/result/region/question.h"

namespace tessera {
namespace {

std::vector<Bounds> boxes_of(const PointUnits& units) {
  std::vector<Bounds> boxes;
  for (const auto& unit : units.list()) boxes.push_back(unit.bounds);
  return boxes;
}

}  // namespace

Regions::Regions(std::unique_ptr<PointUnits> units, int dimension, std::size_t row_bytes, EqualPoints equal)
    : units_(std::move(units)), dimension_(dimension), row_bytes_(row_bytes), equal_(equal), tree_(boxes_of(*units_)) {
  for (const auto& unit : units_->list()) bounds_.add(unit.bounds);
}

Result<RegionCells> Regions::ask(const Box& region, const RegionLimits& limits, const std::stop_token& stop,
                                 const RegionShape& shape) {
  // Cells have no point beyond the bounds of all points.
  Bounds within;
  bool empty = units_->list().empty();
  for (int axis = 0; axis < 3; ++axis) {
    const bool flat = dimension_ == 2 && axis == 2;
    within.lo[axis] = flat ? 0 : std::max(region.lo[axis], bounds_.lo[axis]);
    within.hi[axis] = flat ? 0 : std::min(region.hi[axis], bounds_.hi[axis]);
    empty |= !(within.lo[axis] <= within.hi[axis]);
  }
  RegionCells cells;
  cells.mesh.dimension = dimension_;
  if (!empty) {
    try {
      BOOST_OUTCOME_TRY(answered, ask_within(within, shape, limits, stop));
      cells = std::move(answered);
    } catch (const Stopped&) {
      return error(Errc::interrupted, "interrupted; nothing is kept");
    } catch (const KernelFull&) {
      return error(Errc::memory,
                   "the region needs more points than can be triangulated at once; ask for a smaller one");
    } catch (const std::bad_alloc&) {
      return worded([] { return error(Errc::memory, "the system has no more memory to give"); });
    }
  }
  RegionFigures& figures = cells.figures;
  figures.units = units_->list().size();
  for (const auto& unit : units_->list()) {
    figures.points += unit.points;
    figures.bytes += unit.bytes;
  }
  figures.bytes_read = units_->bytes_read() - std::exchange(bytes_told_, units_->bytes_read());
  return cells;
}

std::uint64_t Regions::loaded_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& [number, unit] : loaded_) bytes += unit.bytes();
  return bytes;
}

void Regions::forget(std::uint64_t bytes_max) {
  std::uint64_t bytes = loaded_bytes();
  std::vector<std::pair<std::chrono::steady_clock::time_point, std::size_t>> oldest;
  for (const auto& [number, unit] : loaded_) oldest.emplace_back(unit.used, number);
  std::sort(oldest.begin(), oldest.end());
  for (const auto& [used, number] : oldest) {
    if (bytes <= bytes_max) return;
    bytes -= loaded_.at(number).bytes();
    loaded_.erase(number);
  }
}

Result<RegionCells> Regions::ask_within(const Bounds& region, const RegionShape& shape, const RegionLimits& limits,
                                        const std::stop_token& stop) {
  tree_.begin(region);
  return RegionQuestion(*units_, loaded_, tree_, dimension_, row_bytes_, equal_, region, shape, limits, stop).answer();
}

}  // namespace tessera
