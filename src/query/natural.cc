#include "src/query/natural.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "src/predicates/exact/predicates.h"

namespace tessera::query {
namespace {

using Corners = std::array<Vec, 4>;

// What the weights of a point are summed from. Positions are relative to the point.
class Sibson {
 public:
  Sibson(Walker& walker, const Point& q, std::size_t corners) : walker_(walker), q_(q), n_(corners) {}

  // False: q is on the hull.
  Result<bool> gather(Place first) {
    BOOST_OUTCOME_TRY(added, look_at(first));
    if (added < 0) return false;  // as only a damaged result has it
    for (std::size_t z = 0; z < zone_.size(); ++z) {
      for (std::size_t k = 0; k < n_; ++k) {
        BOOST_OUTCOME_TRY(beyond, walker_.across(zone_[z].place, k));
        int other = -1;
        if (beyond) {
          BOOST_OUTCOME_TRY(found, look_at(beyond));
          other = found;
        }
        if (other >= 0) {
          // Seen from both sides.
          add(facet_of(z, k), zone_[z].centre, zone_[static_cast<std::size_t>(other)].centre, 0.5L);
        } else if (!add_border(z, k)) {
          return false;
        }
      }
    }
    add_new_edges();
    return true;
  }

  // Empty when rounding has spoilt them.
  std::vector<Weight> weights() {
    std::sort(shares_.begin(), shares_.end(), [](const Share& a, const Share& b) { return a.of.id() < b.of.id(); });
    std::vector<Weight> weights;
    long double all = 0;
    Vec missed;
    long double reach = 0;
    for (std::size_t i = 0; i < shares_.size();) {
      Share sum = shares_[i];
      for (++i; i < shares_.size() && shares_[i].of.id() == sum.of.id(); ++i) sum.of.weight += shares_[i].of.weight;
      all += sum.of.weight;
      missed = missed + sum.of.weight * sum.at;
      reach = std::max(reach, std::sqrt(dot(sum.at, sum.at)));
      weights.push_back(sum.of);
    }
    bool good = std::isfinite(all) && all != 0 && std::sqrt(dot(missed, missed)) <= 1e-9L * reach * std::abs(all);
    for (auto& weight : weights) {
      weight.weight /= all;
      good = good && weight.weight >= -1e-9L;
      weight.weight = std::max(weight.weight, 0.0L);
    }
    if (!good) weights.clear();
    return weights;
  }

 private:
  struct ZoneCell {
    Place place;
    Corners at;
    Vec centre;
  };
  // Facet of a zone cell or of a new one; a corner without a tile is q.
  struct Facet {
    std::array<Weight, 3> of;
    std::array<Vec, 3> at;
  };
  struct Share {
    Weight of;
    Vec at;
  };
  struct Border {
    Facet facet;
    Vec centre;  // of q and the facet
  };

  // The place in zone_, or -1: q is not inside its sphere.
  Result<int> look_at(Place place) {
    const auto [entry, is_new] = seen_.emplace(place.tile->ids(place.cell), -1);
    if (!is_new) return entry->second;
    std::array<Point, 4> p;
    for (std::size_t k = 0; k < n_; ++k) p[k] = place.tile->point(place.tile->vertex(place.cell, k));
    const int side =
        n_ == 4 ? exact::in_sphere_3(p[0], p[1], p[2], p[3], q_) : exact::in_circle_2(p[0], p[1], p[2], q_);
    if (side <= 0) return -1;
    ZoneCell cell{.place = place, .at = {}, .centre = {}};
    for (std::size_t k = 0; k < n_; ++k) cell.at[k] = relative(p[k], q_);
    cell.centre = circumcentre({cell.at.data(), n_});
    entry->second = static_cast<int>(zone_.size());
    zone_.push_back(cell);
    return entry->second;
  }

  Facet facet_of(std::size_t z, std::size_t k) const {
    Facet facet;
    for (std::size_t i = 0; i + 1 < n_; ++i) {
      const std::size_t corner = facet_corner(n_, k, i);
      facet.of[i] = {zone_[z].place.tile, zone_[z].place.tile->vertex(zone_[z].place.cell, corner), 0};
      facet.at[i] = zone_[z].at[corner];
    }
    return facet;
  }

  void add(const Facet& facet, const Vec& from, const Vec& to, long double times) {
    const auto shares = edge_shares({facet.at.data(), n_ - 1}, from, to);
    for (std::size_t i = 0; i + 1 < n_; ++i) {
      if (facet.of[i].tile == nullptr) continue;
      Share share{facet.of[i], facet.at[i]};
      share.of.weight = times * shares[i];
      shares_.push_back(share);
    }
  }

  // The Voronoi edge across the facet ends where the facet and q have their sphere. False when q is in its plane.
  bool add_border(std::size_t z, std::size_t k) {
    Border border{.facet = facet_of(z, k), .centre = {}};
    std::array<Point, 3> p;
    for (std::size_t i = 0; i + 1 < n_; ++i) p[i] = border.facet.of[i].tile->point(border.facet.of[i].vertex);
    const int side = n_ == 4 ? exact::orientation_3(p[0], p[1], p[2], q_) : exact::orientation_2(p[0], p[1], q_);
    if (side <= 0) return false;
    Corners at;
    std::copy(border.facet.at.begin(), border.facet.at.end(), at.begin());
    at[n_ - 1] = Vec{};
    border.centre = circumcentre({at.data(), n_});
    add(border.facet, zone_[z].centre, border.centre, 1);
    borders_.push_back(border);
    return true;
  }

  // Edges of q's own Voronoi cell, between those spheres; what they bound is outside what the vertices lose.
  void add_new_edges() {
    using Ridge = std::array<PointId, 2>;  // all corners of a border facet but one, sorted
    std::map<Ridge, std::array<std::pair<int, std::size_t>, 2>> sides;
    std::map<Ridge, std::size_t> count;
    for (std::size_t b = 0; b < borders_.size(); ++b) {
      for (std::size_t k = 0; k + 1 < n_; ++k) {
        Ridge ridge{no_id, no_id};
        std::size_t at = 0;
        for (std::size_t i = 0; i + 1 < n_; ++i)
          if (i != k) ridge[at++] = borders_[b].facet.of[i].id();
        std::sort(ridge.begin(), ridge.end());
        if (const std::size_t n = count[ridge]++; n < 2) sides[ridge][n] = {static_cast<int>(b), k};
      }
    }
    for (const auto& [ridge, both] : sides) {
      if (count[ridge] != 2) continue;  // then rounding is not all that is wrong, and the sum will tell
      for (std::size_t s = 0; s < 2; ++s) {
        const Border& here = borders_[static_cast<std::size_t>(both[s].first)];
        const Border& there = borders_[static_cast<std::size_t>(both[1 - s].first)];
        Facet facet;
        for (std::size_t i = 0; i + 1 < n_; ++i) {
          const std::size_t corner = facet_corner(n_, both[s].second, i);
          if (corner == n_ - 1) continue;  // q: no tile, at the origin
          facet.of[i] = here.facet.of[corner];
          facet.at[i] = here.facet.at[corner];
        }
        add(facet, here.centre, there.centre, -0.5L);
      }
    }
  }

  Walker& walker_;
  Point q_;
  std::size_t n_;  // corners of a cell
  std::vector<ZoneCell> zone_;
  std::map<CellIds, int> seen_;
  std::vector<Border> borders_;
  std::vector<Share> shares_;
};

}  // namespace

std::vector<Weight> linear_weights(const Located& located, const Point& q) {
  const QueryTile& tile = *located.place.tile;
  const std::size_t n = tile.corners();
  Corners at;
  std::vector<Weight> weights(n);
  for (std::size_t k = 0; k < n; ++k) {
    weights[k] = {&tile, tile.vertex(located.place.cell, k), 0};
    at[k] = relative(tile.point(weights[k].vertex), q);
  }
  long double all = 0;
  for (std::size_t k = 0; k < n; ++k) {
    if ((located.on_facets >> k & 1u) != 0) continue;
    const auto corner = [&](std::size_t i) { return at[facet_corner(n, k, i)]; };
    const long double part =
        n == 4 ? dot(corner(0), cross(corner(1), corner(2))) : corner(0).x * corner(1).y - corner(0).y * corner(1).x;
    weights[k].weight = std::abs(part);
    all += weights[k].weight;
  }
  // Flatter than floating point has it: the nearest vertex.
  if (!(all > 0) || !std::isfinite(all)) {
    std::size_t nearest = 0;
    for (std::size_t k = 0; k < n; ++k) {
      weights[k].weight = 0;
      if (dot(at[k], at[k]) < dot(at[nearest], at[nearest])) nearest = k;
    }
    weights[nearest].weight = all = 1;
  }
  for (auto& weight : weights) weight.weight /= all;
  return weights;
}

Result<std::vector<Weight>> natural_weights(Walker& walker, const Located& located, const Point& q) {
  const std::size_t n = located.place.tile->corners();
  if (std::popcount(located.on_facets) == static_cast<int>(n) - 1) return std::vector<Weight>{};  // a vertex
  Sibson sibson(walker, q, n);
  BOOST_OUTCOME_TRY(inside, sibson.gather(located.place));
  if (!inside) return std::vector<Weight>{};
  return sibson.weights();
}

}  // namespace tessera::query
