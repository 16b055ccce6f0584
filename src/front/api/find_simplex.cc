#include "src/front/api/find_simplex.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {
namespace {

// The walk from the nearest sample takes a few steps, about as long as the search for the sample. 60 cells have nine
// points in 3D.
constexpr std::size_t cells_a_sample = 60;

Bounds bounds_of(const SimplexArrays& arrays) {
  Bounds bounds;
  const auto d = static_cast<std::size_t>(arrays.dimension);
  for (std::size_t i = 0; i < arrays.points.size(); i += d) {
    const double* p = &arrays.points[i];
    bounds.add(Point{p[0], p[1], d == 3 ? p[2] : 0});
  }
  return bounds;
}

// For the choice of the nearer start. Infinite differences only make a bad choice.
double squared_distance(const Point& p, const Point& q) {
  const double x = p.x - q.x, y = p.y - q.y, z = p.z - q.z;
  return x * x + y * y + z * z;
}

template <int d>
int orientation(const std::array<Point, 4>& p) {
  if constexpr (d == 3) {
    return exact::orientation_3(p[0], p[1], p[2], p[3]);
  } else {
    return exact::orientation_2(p[0], p[1], p[2]);
  }
}

}  // namespace

SimplexFinder::SimplexFinder(const SimplexArrays& arrays) : arrays_(arrays), key_(bounds_of(arrays), arrays.dimension) {
  const auto corners = static_cast<std::size_t>(arrays.dimension) + 1;
  const std::size_t cells = arrays.simplices.size() / corners;
  for (std::size_t c = 0; c < cells; c += cells_a_sample) {
    samples_.emplace_back(key_(vertex(arrays.simplices[c * corners])), static_cast<std::int32_t>(c));
  }
  std::sort(samples_.begin(), samples_.end());
}

Point SimplexFinder::point_of(std::span<const double> coordinates, std::size_t i) const {
  const double* p = &coordinates[i * static_cast<std::size_t>(arrays_.dimension)];
  return {p[0], p[1], arrays_.dimension == 3 ? p[2] : 0};
}

std::int32_t SimplexFinder::start(const Point& q, std::uint64_t key, std::int32_t last) const {
  const auto distance = [&](std::int32_t c) {
    return squared_distance(q, vertex(arrays_.simplices[static_cast<std::size_t>(c) * (arrays_.dimension + 1)]));
  };
  auto sample = std::lower_bound(samples_.begin(), samples_.end(), std::pair(key, std::int32_t{0}));
  if (sample == samples_.end()) --sample;
  return distance(sample->second) < distance(last) ? sample->second : last;
}

template <int d>
std::int32_t SimplexFinder::walk(const Point& q, std::int32_t& last) const {
  constexpr int corners = d + 1;
  std::int32_t from = -1;
  for (std::int32_t c = last;;) {
    last = c;
    const std::int32_t* v = &arrays_.simplices[static_cast<std::size_t>(c) * corners];
    const std::int32_t* n = &arrays_.neighbors[static_cast<std::size_t>(c) * corners];
    std::array<Point, 4> p;
    for (int i = 0; i < corners; ++i) p[i] = vertex(v[i]);
    int facet = 0;
    for (; facet < corners; ++facet) {
      if (n[facet] == from && from >= 0) continue;  // the walk came across this facet, so q is on this side
      const Point corner = std::exchange(p[facet], q);
      const int side = orientation<d>(p);
      p[facet] = corner;
      if (side < 0) break;
    }
    if (facet == corners) return c;
    if (n[facet] < 0) return -1;
    from = std::exchange(c, n[facet]);
  }
}

void SimplexFinder::find(std::span<const double> queries, std::span<std::int32_t> out) const {
  struct Query {
    std::uint64_t key;
    std::size_t index;
  };
  std::vector<Query> order;
  order.reserve(out.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Point q = point_of(queries, i);
    out[i] = -1;
    if (is_finite(q)) order.push_back({key_(q), i});
  }
  // Along the Hilbert curve each answer is near the next one, also in memory.
  std::sort(order.begin(), order.end(), [](const Query& a, const Query& b) { return a.key < b.key; });
  std::int32_t last = 0;
  for (const Query& query : order) {
    const Point q = point_of(queries, query.index);
    last = start(q, query.key, last);
    out[query.index] = arrays_.dimension == 3 ? walk<3>(q, last) : walk<2>(q, last);
  }
}

}  // namespace tessera
