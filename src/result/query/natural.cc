#include "src/result/query/natural.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <type_traits>
#include <utility>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::query {
namespace {

template <class Number>
using Corners = std::array<Vec<Number>, 4>;

// Collects the sums for the weights of a point. Positions are relative to the point.
template <class Number>
class Sibson {
 public:
  Sibson(Walker& walker, const Point& q, std::size_t corners) : walker_(walker), q_(q), n_(corners) {}

  // Returns false when q is on the hull.
  Result<bool> gather(CellRef first) {
    BOOST_OUTCOME_TRY(added, look_at(first));
    if (added < 0) return lost_;  // otherwise only a damaged result gets here
    for (std::size_t z = 0; z < zone_.size(); ++z) {
      for (std::size_t k = 0; k < n_; ++k) {
        BOOST_OUTCOME_TRY(beyond, walker_.across(zone_[z].place, k));
        int other = -1;
        if (beyond) {
          BOOST_OUTCOME_TRY(found, look_at(beyond));
          other = found;
        }
        if (other >= 0) {
          // Each edge is seen from both sides.
          add(facet_of(z, k), zone_[z].centre, zone_[static_cast<std::size_t>(other)].centre, Number(0.5));
        } else if (!add_border(z, k)) {
          return false;
        }
      }
    }
    add_new_edges();
    return true;
  }

  // Empty when rounding has spoilt the weights.
  std::vector<Weight> weights() {
    std::sort(shares_.begin(), shares_.end(), [](const Share& a, const Share& b) { return a.of.id() < b.of.id(); });
    std::vector<Share> sums;
    Number all = 0;
    for (const Share& share : shares_) {
      if (sums.empty() || sums.back().of.id() != share.of.id()) {
        sums.push_back(share);
      } else {
        sums.back().part += share.part;
      }
      all += share.part;
    }
    std::vector<Weight> weights;
    if (lost_ || !usable(all)) return weights;
    // Positions are relative to q, so the weighted sum is zero, up to rounding.
    Vec<Long> missed;
    bool good = true;
    for (const Share& sum : sums) {
      const Long part = rounded(sum.part / all);
      const Vec<Long> at{rounded(sum.at.x), rounded(sum.at.y), rounded(sum.at.z)};
      missed = missed + part * at;
      shortest_ = std::min(shortest_, std::sqrt(dot(at, at)));
      good = good && part >= -tolerance;
      weights.push_back(sum.of);
      weights.back().weight = std::max(part, 0.0L);
    }
    if (!good || !(std::sqrt(dot(missed, missed)) <= tolerance * shortest_)) weights.clear();
    return weights;
  }

 private:
  static constexpr Long tolerance = 1e-10L;

  // A cell is too flat for numbers of this precision.
  int lost() {
    lost_ = true;
    return -1;
  }

  struct ZoneCell {
    CellRef place;
    Corners<Number> at;
    Vec<Number> centre;
  };
  // A facet of a zone cell or of a new cell; a corner without a tile is q.
  struct Facet {
    std::array<Weight, 3> of;
    std::array<Vec<Number>, 3> at;
  };
  struct Share {
    Weight of;
    Vec<Number> at;
    Number part = 0;
  };
  struct Border {
    Facet facet;
    Vec<Number> centre;  // of the sphere through q and the facet
  };

  // Returns the index in zone_, or -1 when q is not inside the sphere of the cell.
  Result<int> look_at(CellRef place) {
    const auto [entry, is_new] = seen_.emplace(place.tile->ids(place.cell), -1);
    if (!is_new) return entry->second;
    std::array<Point, 4> p;
    for (std::size_t k = 0; k < n_; ++k) p[k] = place.tile->point(place.tile->vertex(place.cell, k));
    const int side =
        n_ == 4 ? exact::in_sphere_3(p[0], p[1], p[2], p[3], q_) : exact::in_circle_2(p[0], p[1], p[2], q_);
    if (side <= 0) return -1;
    ZoneCell cell{.place = place, .at = {}, .centre = {}};
    for (std::size_t k = 0; k < n_; ++k) cell.at[k] = relative<Number>(p[k], q_);
    const auto centre = circumcentre<Number>({cell.at.data(), n_});
    if (!centre) return lost();
    cell.centre = *centre;
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

  void add(const Facet& facet, const Vec<Number>& from, const Vec<Number>& to, Number times) {
    const auto shares = edge_shares<Number>({facet.at.data(), n_ - 1}, from, to);
    for (std::size_t i = 0; i + 1 < n_; ++i) {
      if (facet.of[i].tile == nullptr) continue;
      shares_.push_back({facet.of[i], facet.at[i], times * shares[i]});
    }
  }

  // The Voronoi edge across the facet ends at the centre of the sphere through the facet and q. Returns false when q is
  // in the plane of the facet.
  bool add_border(std::size_t z, std::size_t k) {
    Border border{.facet = facet_of(z, k), .centre = {}};
    std::array<Point, 3> p;
    for (std::size_t i = 0; i + 1 < n_; ++i) p[i] = border.facet.of[i].tile->point(border.facet.of[i].vertex);
    const int side = n_ == 4 ? exact::orientation_3(p[0], p[1], p[2], q_) : exact::orientation_2(p[0], p[1], q_);
    if (side <= 0) return false;
    Corners<Number> at;
    std::copy(border.facet.at.begin(), border.facet.at.end(), at.begin());
    at[n_ - 1] = {};
    const auto centre = circumcentre<Number>({at.data(), n_});
    if (!centre) {
      lost();
      return true;
    }
    border.centre = *centre;
    for (std::size_t i = 0; i + 1 < n_; ++i) {
      const auto edge = border.facet.at[i] - border.facet.at[i + 2 < n_ ? i + 1 : 0];
      shortest_ = std::min(shortest_, std::sqrt(rounded(dot(edge, edge))));
    }
    add(border.facet, zone_[z].centre, border.centre, Number(1));
    borders_.push_back(border);
    return true;
  }

  // Adds the edges of q's own Voronoi cell, between these centres. The region that they bound is what the vertices
  // lose.
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
      if (count[ridge] != 2) continue;  // then more than rounding is wrong, and the sum will show it
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
        add(facet, here.centre, there.centre, Number(-0.5));
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
  bool lost_ = false;
  Long shortest_ = std::numeric_limits<Long>::infinity();  // edge between neighbours, or between a neighbour and q
};

// Barycentric coordinates that are not yet divided by their sum: volumes, or areas times two. Returns false when
// rounding leaves too little of them.
template <class Number>
bool barycentric(const Located& located, const Point& q, std::array<Number, 4>& parts) {
  const std::size_t n = located.place.tile->corners();
  Corners<Number> at;
  Number size = 0;
  for (std::size_t k = 0; k < n; ++k) {
    at[k] = relative<Number>(located.place.corner(k), q);
    for (const Number& x : {at[k].x, at[k].y, at[k].z}) size = std::max(size, x < 0 ? -x : x);
  }
  Number all = 0;
  for (std::size_t k = 0; k < n; ++k) {
    parts[k] = 0;
    if ((located.on_facets >> k & 1u) != 0) continue;
    const auto corner = [&](std::size_t i) { return at[facet_corner(n, k, i)]; };
    parts[k] =
        n == 4 ? dot(corner(0), cross(corner(1), corner(2))) : corner(0).x * corner(1).y - corner(0).y * corner(1).x;
    if (parts[k] < 0) parts[k] = -parts[k];
    all += parts[k];
  }
  if (!usable(all)) return false;
  for (auto& part : parts) part /= all;
  if constexpr (std::is_same_v<Number, Wide>) return true;
  // Products of this size are rounded at 2^-64 of it.
  return rounded(size * size * (n == 4 ? size : Number(1))) * 0x1p-62L < 1e-14L * rounded(all);
}

}  // namespace

std::vector<Weight> linear_weights(const Located& located, const Point& q) {
  const QueryTile& tile = *located.place.tile;
  const std::size_t n = tile.corners();
  std::vector<Weight> weights(n);
  for (std::size_t k = 0; k < n; ++k) weights[k] = {&tile, tile.vertex(located.place.cell, k), 0};
  if (std::array<Long, 4> parts{}; barycentric(located, q, parts)) {
    for (std::size_t k = 0; k < n; ++k) weights[k].weight = parts[k];
    return weights;
  }
  if (std::array<Wide, 4> parts{}; barycentric(located, q, parts)) {
    for (std::size_t k = 0; k < n; ++k) weights[k].weight = rounded(parts[k]);
    return weights;
  }
  // The cell has no volume, as only a damaged one has, or its volume is out of range: takes the nearest vertex.
  const auto distance = [&](std::size_t k) {
    const Point p = located.place.corner(k);
    return std::hypot(p.x - q.x, p.y - q.y, p.z - q.z);
  };
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < n; ++k)
    if (distance(k) < distance(nearest)) nearest = k;
  weights[nearest].weight = 1;
  return weights;
}

Result<std::vector<Weight>> natural_weights(Walker& walker, const Located& located, const Point& q) {
  const std::size_t n = located.place.tile->corners();
  if (std::popcount(located.on_facets) == static_cast<int>(n) - 1) return std::vector<Weight>{};  // a vertex
  Sibson<Long> fast(walker, q, n);
  BOOST_OUTCOME_TRY(inside, fast.gather(located.place));
  if (!inside) return std::vector<Weight>{};
  if (auto weights = fast.weights(); !weights.empty()) return weights;
  Sibson<Wide> slow(walker, q, n);
  BOOST_OUTCOME_TRY(again, slow.gather(located.place));
  return again ? slow.weights() : std::vector<Weight>{};
}

}  // namespace tessera::query
