#include "src/result/terrain/leg_crossings.h"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::terrain {
namespace {

using Exact = boost::multiprecision::cpp_rational;

// A place on the leg, as a fraction of the leg that is off by at most `error`.
struct EstimatedCrossing {
  Crossing crossing;
  double error = 0;
  Point u, v;  // ends of an edge
  std::size_t cell = 0;
};

template <class Number>
Number area(const Point& a, const Point& b, const Point& p, Number* size = nullptr) {
  const Number left = (Number(a.x) - Number(p.x)) * (Number(b.y) - Number(p.y));
  const Number right = (Number(b.x) - Number(p.x)) * (Number(a.y) - Number(p.y));
  if (size != nullptr) *size = abs(left) + abs(right);
  return left - right;
}

// Where the line from p to q meets the line through a and b, as a fraction of the way from p to q.
Exact ratio_exactly(const Point& a, const Point& b, const Point& p, const Point& q) {
  const Exact at_p = area<Exact>(a, b, p);
  return at_p / Exact(at_p - area<Exact>(a, b, q));
}

struct Ratio {
  double value = 0, error = 0;
};

Ratio ratio(const Point& a, const Point& b, const Point& p, const Point& q) {
  using std::abs;
  double size_p = 0, size_q = 0;
  const double at_p = area<double>(a, b, p, &size_p), at_q = area<double>(a, b, q, &size_q);
  // As in cell_raster.cc, an area is off by at most 4 u of its size.
  const double whole = at_p - at_q, off = 0x1p-50 * (size_p + size_q);
  if (std::abs(whole) > 1e-250 && off < 1e-13 * std::abs(whole))
    return {std::clamp(at_p / whole, 0.0, 1.0), 4 * off / std::abs(whole) + 0x1p-50};
  return {static_cast<double>(ratio_exactly(a, b, p, q)), 0x1p-50};
}

class Leg {
 public:
  explicit Leg(const query::Leg& leg)
      : from_(leg.from), to_(leg.to), axis_(std::abs(to_.x - from_.x) >= std::abs(to_.y - from_.y) ? 0 : 1) {}

  int side(const Point& p) const { return exact::orientation_2(from_, to_, p); }
  // True if p is on the leg. REQUIRES: p is on the line through the leg.
  bool has(const Point& p) const {
    return std::min(from_[axis_], to_[axis_]) <= p[axis_] && p[axis_] <= std::max(from_[axis_], to_[axis_]);
  }
  EstimatedCrossing at_point(Crossing::Kind kind, const std::array<PointId, 3>& ids, const Point& p,
                             double value) const {
    // Halves, because the length of the leg may overflow a double.
    const double fraction = (p[axis_] / 2 - from_[axis_] / 2) / (to_[axis_] / 2 - from_[axis_] / 2);
    EstimatedCrossing estimate{.crossing = {.kind = kind, .ids = ids, .at = p, .fraction = fraction, .value = value},
                               .error = 0x1p-50,
                               .u = p,
                               .v = p};
    if (!std::isfinite(fraction)) estimate.crossing.fraction = static_cast<double>(exactly(estimate));
    return estimate;
  }
  // REQUIRES: u and v are on different sides.
  EstimatedCrossing at_edge(const Corner& u, const Corner& v) const {
    const Ratio fraction = ratio(u.at, v.at, from_, to_), along = ratio(from_, to_, u.at, v.at);
    const auto between = [&](double a, double b) {
      return std::clamp(std::lerp(a, b, along.value), std::min(a, b), std::max(a, b));
    };
    return {.crossing = {.kind = Crossing::Kind::edge,
                         .ids = {u.id, u.id, v.id},
                         .at = {between(u.at.x, v.at.x), between(u.at.y, v.at.y), 0},
                         .fraction = fraction.value,
                         .value = between(u.value, v.value)},
            .error = fraction.error,
            .u = u.at,
            .v = v.at};
  }
  Exact exactly(const EstimatedCrossing& estimate) const {
    if (estimate.crossing.kind == Crossing::Kind::edge) return ratio_exactly(estimate.u, estimate.v, from_, to_);
    const Exact from(from_[axis_]);
    return (Exact(estimate.u[axis_]) - from) / Exact(Exact(to_[axis_]) - from);
  }
  // Returns -1, 0 or 1 when a is before, at or after b on the leg.
  int order(const EstimatedCrossing& a, const EstimatedCrossing& b) const {
    const double apart = a.crossing.fraction - b.crossing.fraction;
    if (std::abs(apart) > a.error + b.error) return apart < 0 ? -1 : 1;
    if (a.crossing.kind == b.crossing.kind && a.crossing.ids == b.crossing.ids && a.u == b.u) return 0;
    return exactly(a).compare(exactly(b));
  }
  const Point& from() const { return from_; }
  const Point& to() const { return to_; }

 private:
  Point from_, to_;
  int axis_;  // the axis along which the leg is longer
};

// Adds the crossings of one cell.
void add_estimates(const Leg& leg, const Triangle& cell, std::size_t number,
                   std::vector<EstimatedCrossing>& estimates) {
  const std::size_t before = estimates.size();
  std::array<int, 3> side{};
  for (std::size_t k = 0; k < 3; ++k) {
    side[k] = leg.side(cell[k].at);
    const PointId id = cell[k].id;
    if (side[k] == 0 && leg.has(cell[k].at))
      estimates.push_back(leg.at_point(Crossing::Kind::vertex, {id, id, id}, cell[k].at, cell[k].value));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = k == 2 ? 0 : k + 1;
    if (side[k] * side[next] >= 0) continue;
    const bool swapped = cell[next].id < cell[k].id;
    const Corner &u = cell[swapped ? next : k], &v = cell[swapped ? k : next];
    const int from = exact::orientation_2(u.at, v.at, leg.from()), to = exact::orientation_2(u.at, v.at, leg.to());
    if (from * to <= 0) estimates.push_back(leg.at_edge(u, v));
  }
  Triangle sorted = cell;
  std::sort(sorted.begin(), sorted.end(), [](const Corner& a, const Corner& b) { return a.id < b.id; });
  for (const Point& end : {leg.from(), leg.to()}) {
    const auto left_of = [&](std::size_t a, std::size_t b) {
      return exact::orientation_2(cell[a].at, cell[b].at, end) >= 0;
    };
    if (left_of(0, 1) && left_of(1, 2) && left_of(2, 0))
      estimates.push_back(
          leg.at_point(Crossing::Kind::end, {sorted[0].id, sorted[1].id, sorted[2].id}, end, value_at(sorted, end)));
  }
  for (std::size_t i = before; i < estimates.size(); ++i) estimates[i].cell = number;
}

}  // namespace

std::vector<Crossing> crossings(const query::Leg& line, std::span<const Triangle> cells) {
  const Leg leg(line);
  std::vector<EstimatedCrossing> estimates;
  for (std::size_t i = 0; i < cells.size(); ++i) add_estimates(leg, cells[i], i, estimates);
  std::sort(estimates.begin(), estimates.end(), [&](const EstimatedCrossing& a, const EstimatedCrossing& b) {
    if (const int order = leg.order(a, b); order != 0) return order < 0;
    return std::tie(a.crossing.kind, a.crossing.ids) < std::tie(b.crossing.kind, b.crossing.ids);
  });
  std::vector<Crossing> result;
  std::vector<std::pair<std::size_t, std::size_t>> of_cell(cells.size(), {cells.size() + estimates.size(), 0});
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (i == 0 || leg.order(estimates[i - 1], estimates[i]) != 0) result.push_back(estimates[i].crossing);
    auto& [first, last] = of_cell[estimates[i].cell];
    first = std::min(first, result.size() - 1);
    last = std::max(last, result.size() - 1);
  }
  // A cell is convex, so there is nothing between two of its places.
  for (const auto& [first, last] : of_cell)
    for (std::size_t i = first; i < last; ++i) result[i].joined = true;
  return result;
}

}  // namespace tessera::terrain
