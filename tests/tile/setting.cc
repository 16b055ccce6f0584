#include "tests/tile/setting.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/geometry/predicates/independent/predicates.h"

namespace tessera::testing {

Assignment assign(const std::string& how, const std::vector<LocalPoint>& points, std::uint32_t tiles,
                  std::uint64_t seed) {
  Assignment a;
  std::mt19937_64 rng(seed);
  if (how == "random") {
    for (std::size_t i = 0; i < points.size(); ++i) a.tile_of.push_back(static_cast<std::uint32_t>(rng() % tiles));
  } else if (how == "single") {
    for (std::size_t i = 0; i < points.size(); ++i) a.tile_of.push_back(static_cast<std::uint32_t>(i));
  } else {  // stripes: equal numbers along x, borders on points
    std::vector<double> xs;
    for (const auto& p : points) xs.push_back(p.at.x);
    std::sort(xs.begin(), xs.end());
    std::vector<double> cuts;
    for (std::uint32_t t = 1; t < tiles; ++t) cuts.push_back(xs[xs.size() * t / tiles]);
    for (const auto& p : points) {
      const auto cut = std::upper_bound(cuts.begin(), cuts.end(), p.at.x);
      a.tile_of.push_back(static_cast<std::uint32_t>(cut - cuts.begin()));
    }
    for (std::uint32_t t = 0; t < tiles; ++t) {
      Box box;
      if (t > 0) box.lo.x = cuts[t - 1];
      if (t + 1 < tiles) box.hi.x = cuts[t];
      a.boxes.push_back(box);
    }
  }
  return a;
}

std::vector<Seed> make_seeds(const std::vector<LocalPoint>& points, const std::vector<std::uint32_t>& tile_of, int d,
                             Announced announced) {
  std::vector<std::size_t> chosen;
  const auto least = std::min_element(points.begin(), points.end(), [](auto& a, auto& b) { return a.at < b.at; });
  chosen.push_back(static_cast<std::size_t>(least - points.begin()));
  for (std::size_t i = 0;
       announced == Announced::spanning && i < points.size() && chosen.size() < static_cast<std::size_t>(d) + 1; ++i) {
    const Point &a = points[chosen[0]].at, p = points[i].at;
    bool independent = p != a;
    if (chosen.size() == 2) {
      const Point& b = points[chosen[1]].at;
      independent = d == 2 ? independent::orientation_2(a, b, p) != 0 : !independent::collinear_3(a, b, p);
    } else if (chosen.size() == 3) {
      independent = independent::orientation_3(a, points[chosen[1]].at, points[chosen[2]].at, p) != 0;
    }
    if (independent) chosen.push_back(i);
  }
  if (announced == Announced::extremes) {
    const auto tiles = static_cast<std::size_t>(*std::max_element(tile_of.begin(), tile_of.end())) + 1;
    for (std::size_t t = 0; t < tiles; ++t) {
      for (int axis = 0; axis < 2 * d; ++axis) {
        std::size_t best = points.size();
        const double sign = axis % 2 ? 1 : -1;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const bool better = best == points.size() || sign * points[i].at[axis / 2] > sign * points[best].at[axis / 2];
          if (tile_of[i] == t && better) best = i;
        }
        if (best < points.size()) chosen.push_back(best);
      }
    }
    std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  }
  std::vector<Seed> seeds;
  for (const std::size_t i : chosen) {
    seeds.push_back({{points[i].at, points[i].id, tile_of[i], 0}, std::numeric_limits<double>::infinity()});
  }
  return seeds;
}

void add_random_seeds(const std::vector<LocalPoint>& points, const std::vector<std::uint32_t>& tile_of,
                      std::mt19937_64& rng, std::vector<Seed>& seeds) {
  const std::uint64_t one_in = std::uint64_t{1} << rng() % 6;
  if (one_in == 1) return;  // none but the necessary ones
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto is_point = [&](const Seed& s) { return s.point.id == points[i].id; };
    if (rng() % one_in != 0 || std::any_of(seeds.begin(), seeds.end(), is_point)) continue;
    const Point& other = points[rng() % points.size()].at;
    const Point& p = points[i].at;
    seeds.push_back({{p, points[i].id, tile_of[i], 0}, std::hypot(p.x - other.x, p.y - other.y, p.z - other.z)});
  }
}

}  // namespace tessera::testing
