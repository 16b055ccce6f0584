#include "src/query/dual.h"

namespace tessera::query {

Vec circumcentre(std::span<const Vec> cell) {
  const Vec b = cell[1] - cell[0], c = cell[2] - cell[0];
  if (cell.size() == 3) {
    const long double area = 2 * (b.x * c.y - b.y * c.x), bb = dot(b, b), cc = dot(c, c);
    return cell[0] + Vec{(bb * c.y - cc * b.y) / area, (cc * b.x - bb * c.x) / area, 0};
  }
  const Vec d = cell[3] - cell[0];
  const long double volume = 2 * dot(b, cross(c, d));
  return cell[0] + (1 / volume) * (dot(b, b) * cross(c, d) + dot(c, c) * cross(d, b) + dot(d, d) * cross(b, c));
}

std::array<long double, 3> edge_shares(std::span<const Vec> facet, const Vec& from, const Vec& to) {
  const Vec turn = cross(from, to);
  if (facet.size() == 2) return {-turn.z / 2, turn.z / 2, 0};
  return {dot(turn, facet[2] - facet[1]) / 12, dot(turn, facet[0] - facet[2]) / 12,
          dot(turn, facet[1] - facet[0]) / 12};
}

}  // namespace tessera::query
