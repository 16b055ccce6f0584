#include "src/result/verify/periodic_space.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "src/base/files/names.h"
#include "src/geometry/predicates/independent/predicates.h"

namespace tessera {
namespace {

using boost::multiprecision::cpp_int;
using boost::multiprecision::int256_t;
using Exact = VolumeSum::Exact;
__extension__ using Int128 = __int128;

// The exponent of the lowest bit of a number that is not 0.
int lowest_bit(double x) {
  int exponent = 0;
  const double fraction = std::frexp(std::abs(x), &exponent);
  const auto digits = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
  return exponent - 53 + std::countr_zero(digits);
}

// The coordinates of a cell's corners along an axis as multiples of a power of two.
struct Scaled {
  int exponent = 0;
  bool few = true;  // the multiples have at most 60 bits
};

Scaled scale_of(std::span<const Point> corners, int axis) {
  Scaled scaled;
  bool any = false;
  double most = 0;
  for (const Point& p : corners) {
    if (p[axis] == 0) continue;
    const int low = lowest_bit(p[axis]);
    scaled.exponent = any ? std::min(scaled.exponent, low) : low;
    any = true;
    most = std::max(most, std::abs(p[axis]));
  }
  scaled.few = !any || std::ilogb(most) - scaled.exponent < 60;
  return scaled;
}

// All corners' coordinates less those of the first one, in steps of 2^exponent.
std::int64_t few_steps(double a, double from, int exponent) {
  return static_cast<std::int64_t>(std::ldexp(a, -exponent)) - static_cast<std::int64_t>(std::ldexp(from, -exponent));
}

// A double as an integer, in steps of 2^exponent; the exponent is at most that of its lowest bit.
cpp_int many_steps(double a, int exponent) {
  if (a == 0) return 0;
  const int low = lowest_bit(a);
  cpp_int steps = static_cast<std::int64_t>(std::ldexp(a, -low));
  steps <<= static_cast<unsigned>(low - exponent);
  return steps;
}

template <class Wide, class Steps>
Wide determinant(int dimension, const std::array<std::array<Steps, 3>, 3>& m) {
  const auto minor = [&](int r, int s, int i, int j) -> Wide {
    if constexpr (std::is_same_v<Steps, std::int64_t>) {
      return Wide(static_cast<Int128>(m[r][i]) * m[s][j] - static_cast<Int128>(m[r][j]) * m[s][i]);
    } else {
      return Wide(m[r][i] * m[s][j] - m[r][j] * m[s][i]);
    }
  };
  if (dimension == 2) return minor(0, 1, 0, 1);
  Wide sum = minor(1, 2, 1, 2);
  sum *= m[0][0];
  Wide second = minor(1, 2, 0, 2), third = minor(1, 2, 0, 1);
  second *= m[0][1];
  third *= m[0][2];
  sum -= second;
  sum += third;
  return sum;
}

Exact times_power_of_two(const cpp_int& value, int exponent) {
  const cpp_int power = cpp_int(1) << static_cast<unsigned>(std::abs(exponent));
  return exponent < 0 ? Exact(value, power) : Exact(cpp_int(value * power));
}

}  // namespace

void VolumeSum::add(std::span<const Point> corners) {
  const auto dimension = static_cast<int>(corners.size()) - 1;
  std::array<Scaled, 3> scaled;
  int exponent = 0;
  bool few = true;
  for (int axis = 0; axis < dimension; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    scaled[i] = scale_of(corners, axis);
    exponent += scaled[i].exponent;
    few = few && scaled[i].few;
  }
  const auto fill = [&](auto& m, const auto& steps) {
    for (std::size_t r = 0; r + 1 < corners.size(); ++r) {
      for (std::size_t axis = 0; axis + 1 < corners.size(); ++axis)
        m[r][axis] =
            steps(corners[r + 1][static_cast<int>(axis)], corners[0][static_cast<int>(axis)], scaled[axis].exponent);
    }
  };
  if (few) {
    std::array<std::array<std::int64_t, 3>, 3> m{};
    fill(m, few_steps);
    few_[exponent] += determinant<int256_t>(dimension, m);
    return;
  }
  std::array<std::array<cpp_int, 3>, 3> m{};
  fill(m, [](double a, double from, int e) -> cpp_int { return many_steps(a, e) - many_steps(from, e); });
  many_[exponent] += determinant<cpp_int>(dimension, m);
}

Exact VolumeSum::value() const {
  Exact sum = 0;
  for (const auto& [exponent, part] : few_) sum += times_power_of_two(cpp_int(part), exponent);
  for (const auto& [exponent, part] : many_) sum += times_power_of_two(part, exponent);
  return sum;
}

PeriodicSpace::PeriodicSpace(int dimension, const Period& period, TileSource source,
                             const std::filesystem::path& scratch, std::uint64_t memory_bytes, std::stop_token stop)
    : dimension_(dimension),
      period_(period),
      source_(std::move(source)),
      stop_(stop),
      facets_(scratch, memory_bytes, std::move(stop)) {
  for (int axis = 0; axis < dimension; ++axis) {
    if (!period.along(axis)) open_.push_back(axis);
  }
}

PeriodicSpace::Flat PeriodicSpace::flat(const Point& p) const {
  return {p[open_[0]], open_.size() > 1 ? p[open_[1]] : 0};
}

int PeriodicSpace::side(const Flat& a, const Flat& b, const Flat& c) {
  return independent::orientation_2({a.u, a.v, 0}, {b.u, b.v, 0}, {c.u, c.v, 0});
}

void PeriodicSpace::add_vertex(const Point& own) {
  if (open_.empty()) return;
  flat_.push_back(flat(own));
  if (flat_.size() < shrink_at_) return;
  shrink();
  shrink_at_ = std::max(shrink_at_, 2 * flat_.size());
}

// Andrew's monotone chain.
void PeriodicSpace::shrink() {
  std::sort(flat_.begin(), flat_.end());
  flat_.erase(std::unique(flat_.begin(), flat_.end()), flat_.end());
  if (flat_.size() < 3) return;
  if (open_.size() == 1) {
    flat_ = {flat_.front(), flat_.back()};
    return;
  }
  std::vector<Flat> corners;
  const auto chain = [&](auto begin, auto end) {
    const std::size_t first = corners.size();
    for (auto at = begin; at != end; ++at) {
      while (corners.size() >= first + 2 && side(corners[corners.size() - 2], corners.back(), *at) <= 0)
        corners.pop_back();
      corners.push_back(*at);
    }
    corners.pop_back();  // the next chain begins with it
  };
  chain(flat_.begin(), flat_.end());
  chain(flat_.rbegin(), flat_.rend());
  flat_ = std::move(corners);
}

Status PeriodicSpace::add_hull_facet(std::span<const Point> corners, const CellRef& cell, const IdSet& ids) {
  if (open_.empty())
    return wrong_cell(source_, cell, ids, "has no neighbour across a facet, though all axes have periods");
  ++hull_facets_;
  Facet facet{{}, cell, ids};
  for (std::size_t i = 0; i < corners.size(); ++i) facet.at[i] = flat(corners[i]);
  for (std::size_t i = corners.size(); i < 3; ++i) facet.at[i] = facet.at[0];
  return facets_.push(facet);
}

// A facet lies in the border of B if its corners lie on one line of the border of C.
bool PeriodicSpace::in_border(const Facet& facet) const {
  if (open_.size() == 1) {
    const bool low = std::ranges::all_of(facet.at, [&](const Flat& p) { return p == flat_.front(); });
    return low || std::ranges::all_of(facet.at, [&](const Flat& p) { return p == flat_.back(); });
  }
  const auto [least, greatest] = std::minmax_element(facet.at.begin(), facet.at.end());
  if (*least == *greatest) return false;
  const Flat from = *least, to = *greatest;
  if (!std::ranges::all_of(facet.at, [&](const Flat& p) { return side(from, to, p) == 0; })) return false;
  int sides = 0;
  for (const Flat& corner : flat_) {
    const int where = side(from, to, corner);
    if (where * sides < 0) return false;
    if (where != 0) sides = where;
  }
  return true;
}

Exact PeriodicSpace::measure() const {
  if (open_.empty()) return 1;
  if (open_.size() == 1) return Exact(flat_.back().u) - Exact(flat_.front().u);
  Exact sum = 0;
  for (std::size_t i = 0; i < flat_.size(); ++i) {
    const Flat &a = flat_[i], &b = flat_[(i + 1) % flat_.size()];
    sum += Exact(a.u) * Exact(b.v) - Exact(b.u) * Exact(a.v);
  }
  return sum;
}

Status PeriodicSpace::finish() {
  shrink();
  const Exact measured = flat_.size() > open_.size() || open_.empty() ? measure() : Exact(0);
  if (measured <= 0)
    return error(Errc::not_delaunay,
                 manifest_file(source_.folder()).string() + ": the vertices do not span the axes that have no period");
  BOOST_OUTCOME_TRYV(facets_.for_each([&](const Facet& facet) -> Status {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while verifying");
    if (in_border(facet)) return success();
    return wrong_cell(source_, facet.cell, facet.ids, "has no neighbour across a facet that is not on the hull");
  }));
  // d! times the volume: C has dimension k, and d! = d!/k! k!.
  Exact wanted = measured;
  for (int axis = 0; axis < dimension_; ++axis) {
    if (period_.along(axis)) wanted *= Exact(period_.length[static_cast<std::size_t>(axis)]);
  }
  for (int factor = static_cast<int>(open_.size()) + 1; factor <= dimension_; ++factor) wanted *= factor;
  const Exact got = volume_.value();
  if (got == wanted) return success();
  return error(Errc::not_delaunay, manifest_file(source_.folder()).string() +
                                       ": the volumes of the main cells add up to " + (got < wanted ? "less" : "more") +
                                       " than the volume of a period (" +
                                       std::to_string(Exact(got / wanted).convert_to<double>()) + " times)");
}

}  // namespace tessera
