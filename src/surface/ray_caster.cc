#include "src/surface/ray_caster.h"

#include <algorithm>
#include <cmath>

#include "src/surface/line.h"

namespace tessera::surface {

namespace {

// Returns in which direction a and b follow each other, as seen along the ray.
int side(const RayRecord& ray, const Point& a, const Point& b) {
  const int sign = side_of_line(ray.from, ray.towards, a, b);
  return ray.behind != 0 ? -sign : sign;
}

}  // namespace

Status RayCaster::cast(std::int32_t v, const Point& sensor, double sigma, std::uint32_t vote) {
  RayRecord ray{
      .from = tile_.point(v), .towards = sensor, .sigma = sigma, .cell = {}, .opposite = {}, .of = tile_.id(v)};
  for (const std::uint32_t number : tile_.star(v)) {
    const auto cell = static_cast<std::int32_t>(number);
    std::size_t k = 0;
    while (tile_.vertex(cell, k) != v) ++k;
    const auto at = [&](std::size_t i) { return tile_.point(tile_.vertex(cell, facet_corners[k][i])); };
    const Point a = at(0), b = at(1), c = at(2);
    const int sign = side_of_line(ray.from, sensor, a, b);
    if (side_of_line(ray.from, sensor, b, c) != sign || side_of_line(ray.from, sensor, c, a) != sign) continue;
    ray.behind = sign < 0 ? 1 : 0;
    ray.vote = sign < 0 ? vote : full_vote;
    BOOST_OUTCOME_TRYV(follow(ray, cell, k));
  }
  return success();
}

Status RayCaster::go_on(const RayRecord& ray) {
  BOOST_OUTCOME_TRY(cell, tile_.find(ray.cell));
  BOOST_OUTCOME_TRY(exit, tile_.corner_of(cell, ray.opposite));
  return follow(ray, cell, exit);
}

void RayCaster::end(const RayRecord& ray, std::int32_t cell) {
  tile_.excess(cell) += ray.behind != 0 ? -std::int64_t{ray.vote} : std::int64_t{ray.vote};
}

Status RayCaster::follow(RayRecord ray, std::int32_t cell, std::size_t exit) {
  const double limit = ray.behind != 0 ? ray.sigma : energy_.ray_length * ray.sigma;
  const Point way{ray.towards.x - ray.from.x, ray.towards.y - ray.from.y, ray.towards.z - ray.from.z};
  const double length = std::sqrt(way.x * way.x + way.y * way.y + way.z * way.z);
  std::array<std::int32_t, 3> facet;
  for (std::size_t i = 0; i < 3; ++i) facet[i] = tile_.vertex(cell, facet_corners[exit][i]);
  for (; ray.steps < cells_; ++ray.steps) {
    ++steps_;
    const double far =
        length * part_to_plane(ray.from, way, tile_.corner(facet[0]), tile_.corner(facet[1]), tile_.corner(facet[2]));
    if (std::isfinite(far)) ray.reached = std::max(ray.reached, far);
    const std::int32_t next = tile_.neighbor(cell, exit);
    // Whether the sensor is before the facet is tested exactly, as the distance of the facet is rounded.
    const auto at = [&](std::size_t i) { return tile_.point(facet[i]); };
    const bool sensor = ray.behind == 0 && !is_beyond(at(0), at(1), at(2), ray.towards);
    if (sensor || ray.reached > limit || (next == SurfaceTile::outside && ray.behind != 0)) {
      end(ray, cell);
      return success();
    }
    const std::uint32_t weight = ray.behind != 0 ? 0 : visibility_weight(ray.reached, ray.sigma, ray.vote);
    if (next == SurfaceTile::outside) {  // beyond the hull, all is outside
      tile_.excess(cell) += weight;
      return success();
    }
    if (next == SurfaceTile::elsewhere) {
      const auto least =
          std::min_element(facet.begin(), facet.end(), [&](auto a, auto b) { return tile_.id(a) < tile_.id(b); });
      ray.cell = tile_.name(cell);
      ray.opposite = tile_.id(tile_.vertex(cell, exit));
      leaving_.emplace_back(tile_.owner(*least), ray);
      return success();
    }
    BOOST_OUTCOME_TRY(apex, tile_.corner_towards(next, cell));
    // The arc from `next` gets capacity for the weight, and carries as much flow at once. What is left is the arc back.
    std::uint32_t& arc = tile_.arc(cell, exit);
    arc = saturating(arc, weight);
    tile_.excess(cell) += weight;
    tile_.excess(next) -= weight;
    BOOST_OUTCOME_TRY(left, exit_of(ray, next, facet, apex));
    exit = left;
    cell = next;
  }
  return tile_.corrupt("a ray goes through more cells than there are");
}

// The ray has come through `facet`, whose vertices appear counterclockwise from where the ray goes. It leaves across
// the facet of the apex and of the edge between whose ends it passes. If the ray meets the line of a vertex and the
// apex, it does not leave across the two facets of that edge: it begins in their planes.
Result<std::size_t> RayCaster::exit_of(const RayRecord& ray, std::int32_t cell, std::array<std::int32_t, 3>& facet,
                                       std::size_t apex_corner) const {
  const std::int32_t apex = tile_.vertex(cell, apex_corner);
  const Point& x = tile_.point(apex);
  const auto of = [&](std::size_t i) { return side(ray, tile_.point(facet[i]), x); };
  std::size_t away = 0;  // the vertex that is not in the facet across which the ray leaves
  if (const int a = of(0); a < 0) {
    away = of(1) > 0 ? 2 : 0;
  } else if (a > 0) {
    away = of(2) < 0 ? 1 : 0;
  }
  const PointId opposite = tile_.id(facet[away]);
  facet[away] = apex;
  return tile_.corner_of(cell, opposite);
}

}  // namespace tessera::surface
