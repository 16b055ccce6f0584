#include "src/result/verify/hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "src/geometry/predicates/independent/predicates.h"

namespace tessera {

namespace {

// Integer weights from a small range. Rays through a ridge are rare, and it is practically impossible that all of them
// go through ridges.
constexpr int rays = 4;
constexpr unsigned weight_max = 1000;

IdSet ids_of(const HullFacet& facet, int dimension) {
  IdSet ids{padding_id, padding_id, padding_id, padding_id};
  for (int i = 0; i < dimension; ++i) ids[static_cast<std::size_t>(i)] = facet.ids[static_cast<std::size_t>(i)];
  return ids;
}

template <class T>
T determinant(const std::array<T, 3>& a, const std::array<T, 3>& b, const std::array<T, 3>& c) {
  return T(a[0] * (b[1] * c[2] - b[2] * c[1])) - T(a[1] * (b[0] * c[2] - b[2] * c[0])) +
         T(a[2] * (b[0] * c[1] - b[1] * c[0]));
}

template <class T>
int sign_of(const T& value) {
  return value > 0 ? 1 : value < 0 ? -1 : 0;
}

}  // namespace

Hull::Hull(int dimension, TileSource source, const std::filesystem::path& scratch, std::uint64_t memory_bytes,
           std::stop_token stop)
    : dimension_(dimension), source_(std::move(source)), ridges_(scratch, memory_bytes, std::move(stop)) {}

Error Hull::wrong_facet(const HullFacet& facet, const std::string& reason) const {
  return wrong_tile(source_, facet.cell.tile,
                    "the hull facet of cell " + std::to_string(facet.cell.cell) + " with vertices " +
                        text_of(ids_of(facet, dimension_)) + " " + reason);
}

int Hull::orientation(const HullFacet& facet, const Point& p) const {
  return dimension_ == 2 ? independent::orientation_2(facet.at[0], facet.at[1], p)
                         : independent::orientation_3(facet.at[0], facet.at[1], facet.at[2], p);
}

Status Hull::add(const HullFacet& facet, const Core& cell) {
  if (!core_) {
    core_ = cell;
    aim(facet);
  }
  ++facets_;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(dimension_); ++i)
    if (orientation(facet, core_->at[i]) < 0)
      return wrong_facet(facet, "is not on the hull: vertex " + to_string(core_->ids[i]) + " lies beyond it");
  for (auto& ray : rays_) count_hit(facet, ray);

  for (std::size_t i = 0; i < static_cast<std::size_t>(dimension_); ++i) {
    Ridge ridge{};
    ridge.facet = facet;
    ridge.opposite = static_cast<std::uint8_t>(i);
    if (dimension_ == 2) {
      ridge.ids = {facet.ids[1 - i], padding_id};
      ridge.ascending = i == 0;
    } else {
      const PointId a = facet.ids[(i + 1) % 3], b = facet.ids[(i + 2) % 3];
      ridge.ids = {std::min(a, b), std::max(a, b)};
      ridge.ascending = a < b;
    }
    BOOST_OUTCOME_TRYV(ridges_.push(ridge));
  }
  return success();
}

void Hull::aim(const HullFacet& facet) {
  std::mt19937 random(20200611);
  for (int r = 0; r < rays; ++r) {
    Ray ray;
    const auto mix = [&](const auto& points, int count, std::array<Exact, 3>& exact, std::array<double, 3>& near) {
      unsigned total = 0;
      for (int i = 0; i < count; ++i) {
        const unsigned weight = 1 + static_cast<unsigned>(random() % weight_max);
        total += weight;
        for (std::size_t axis = 0; axis < 3; ++axis)
          exact[axis] += Exact(points[static_cast<std::size_t>(i)][static_cast<int>(axis)]) * weight;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        exact[axis] /= total;
        near[axis] = exact[axis].template convert_to<double>();
      }
    };
    mix(core_->at, dimension_ + 1, ray.exact_o, ray.o);
    mix(facet.at, dimension_, ray.exact_p, ray.p);
    rays_.push_back(std::move(ray));
  }
}

int Hull::side(const Ray& ray, const Point& u, const Point& v) const {
  std::array<double, 3> a, b, c{0, 0, 1};
  double largest = 0, magnitude = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const int axis = static_cast<int>(i);
    a[i] = ray.p[i] - ray.o[i];
    b[i] = u[axis] - ray.o[i];
    if (dimension_ == 3) c[i] = v[axis] - ray.o[i];
    largest = std::max({largest, std::abs(a[i]), std::abs(b[i]), dimension_ == 3 ? std::abs(c[i]) : 1.0});
    magnitude = std::max({magnitude, std::abs(ray.o[i]), std::abs(ray.p[i]), std::abs(u[axis]), std::abs(v[axis])});
  }
  // Entries are at most D = `largest` and off by at most 4 eps M (o and p are rounded once, a difference once; M is the
  // largest coordinate, D <= 2 M). So the six products of three are off by 6 * 3 * 4 eps M D^2, and their evaluation
  // adds at most 6 * 5 eps D^3 <= 60 eps M D^2. Together this is less than 256 eps M D^2. In 2D, D >= 1 covers the
  // third row.
  const double value = determinant(a, b, c);
  const double bound = 256 * std::numeric_limits<double>::epsilon() * std::max(magnitude, largest) * largest * largest;
  if (std::isfinite(bound) && bound > std::numeric_limits<double>::min() && std::abs(value) > bound)
    return sign_of(value);

  std::array<Exact, 3> ea, eb, ec{Exact(0), Exact(0), Exact(1)};
  for (std::size_t i = 0; i < 3; ++i) {
    const int axis = static_cast<int>(i);
    ea[i] = ray.exact_p[i] - ray.exact_o[i];
    eb[i] = Exact(u[axis]) - ray.exact_o[i];
    if (dimension_ == 3) ec[i] = Exact(v[axis]) - ray.exact_o[i];
  }
  return sign_of(determinant(ea, eb, ec));
}

// The facet faces o. Seen from o, the ray passes inside the facet when it passes all edges on the same side. As
// orientation(at..., o) > 0, that is the negative side; it is the positive side when the backward half of the line
// meets the facet.
void Hull::count_hit(const HullFacet& facet, Ray& ray) const {
  int zeros = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(dimension_); ++i) {
    int passed = side(ray, facet.at[i], facet.at[(i + 1) % 3]);
    if (dimension_ == 2 && i == 1) passed = -passed;
    if (passed > 0) return;
    if (passed == 0) ++zeros;
  }
  if (zeros > 0) {
    ray.through_ridge = true;
  } else {
    ++ray.hits;
  }
}

Status Hull::check_ridge(std::span<const Ridge> group) const {
  if (group.size() != 2)
    return wrong_facet(group[0].facet, "has a border that " + std::to_string(group.size()) +
                                           " hull facets share instead of two: the hull has a hole or branches");
  if (group[0].ascending == group[1].ascending)
    return wrong_facet(group[0].facet, "and the next one, with vertices " +
                                           text_of(ids_of(group[1].facet, dimension_)) + ", face opposite sides");
  if (orientation(group[0].facet, group[1].facet.at[group[1].opposite]) < 0)
    return wrong_facet(group[0].facet, "has vertex " + to_string(group[1].facet.ids[group[1].opposite]) +
                                           " of the next facet beyond it: the hull is not convex");
  return success();
}

Status Hull::finish() {
  BOOST_OUTCOME_TRYV(for_each_group(
      ridges_, 64, [](const Ridge& a, const Ridge& b) { return a.ids == b.ids; },
      [&](std::span<const Ridge> group) { return check_ridge(group); }));
  bool decided = false;
  for (const auto& ray : rays_) {
    if (ray.through_ridge) continue;
    if (ray.hits != 1)
      return error(Errc::not_delaunay, source_.folder().string() + ": the hull winds " + std::to_string(ray.hits) +
                                           " times around the cell of vertices " + text_of(core_->ids) +
                                           ": cells overlap");
    decided = true;
  }
  if (!rays_.empty() && !decided)
    return error(Errc::not_delaunay, source_.folder().string() + ": all rays from the cell of vertices " +
                                         text_of(core_->ids) + " leave the hull through borders of its facets");
  return success();
}

}  // namespace tessera
