#include "src/surface/umbrellas.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace tessera::surface {

namespace {

constexpr std::size_t none = ~std::size_t{0};
// How far a copy moves towards the mean: small against the triangles, and more than the steps of 32-bit floats.
constexpr double off = 1.0 / 64;

// A triangle at a vertex: its number among all facets, and its other two vertices.
struct Leaf {
  std::size_t facet = 0;
  std::array<std::int32_t, 2> others{};
};

class Umbrellas {
 public:
  Umbrellas(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule, const Boundary& boundary,
            std::span<const SurfaceFacet> facets)
      : tile_(tile), labels_(labels), rule_(rule), boundary_(boundary), facets_(facets) {
    for (std::size_t i = 0; i < facets.size(); ++i) by_place_.emplace_back(place(facets[i].cell, facets[i].corner), i);
    std::sort(by_place_.begin(), by_place_.end());
  }

  Result<Splits> find() {
    for (const auto& [vertex, leaves] : at_own_vertices()) {
      BOOST_OUTCOME_TRYV(look_at(vertex, leaves));
    }
    return std::move(splits_);
  }

 private:
  static std::uint64_t place(std::int32_t cell, std::size_t corner) {
    return 4 * static_cast<std::uint64_t>(cell) + corner;
  }
  bool outside(std::int32_t cell) const { return labels_[static_cast<std::size_t>(cell)] == Label::outside; }

  std::vector<std::pair<std::int32_t, std::vector<Leaf>>> at_own_vertices() const {
    std::vector<std::pair<std::int32_t, Leaf>> all;
    for (std::size_t i = 0; i < facets_.size(); ++i) {
      const auto at = vertices_of(tile_, facets_[i]);
      for (std::size_t k = 0; k < 3; ++k)
        if (at[k] < tile_.own_vertices()) all.push_back({at[k], {i, {at[(k + 1) % 3], at[(k + 2) % 3]}}});
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::pair<std::int32_t, std::vector<Leaf>>> out;
    for (const auto& [vertex, leaf] : all) {
      if (out.empty() || out.back().first != vertex) out.push_back({vertex, {}});
      out.back().second.push_back(leaf);
    }
    return out;
  }

  // Whether what is beyond a facet of the hull is outside.
  bool outside_beyond(std::int32_t cell, std::size_t corner) const {
    return boundary_.below || !is_inside_beyond(tile_, cell, corner, rule_);
  }

  std::size_t number_of(std::int32_t cell, std::size_t corner) const {
    const auto wanted = std::pair(place(cell, corner), std::size_t{0});
    const auto found = std::lower_bound(by_place_.begin(), by_place_.end(), wanted);
    return found != by_place_.end() && found->first == wanted.first ? found->second : none;
  }

  // Goes round the edge v-u from one facet of the hull to the other, which is in the star of v.
  Result<SurfaceFacet> other_hull_facet(std::int32_t v, std::int32_t u, std::int32_t cell, std::size_t corner) const {
    for (const std::uint32_t other : tile_.star(v)) {
      const auto c = static_cast<std::int32_t>(other);
      for (std::size_t k = 0; k < 4; ++k) {
        if (tile_.neighbor(c, k) != SurfaceTile::outside || (c == cell && k == corner)) continue;
        bool has_v = false, has_u = false;
        for (std::size_t i = 0; i < 4; ++i) {
          if (i == k) continue;
          has_v |= tile_.vertex(c, i) == v;
          has_u |= tile_.vertex(c, i) == u;
        }
        if (has_v && has_u) return SurfaceFacet{c, static_cast<std::uint8_t>(k), true};
      }
    }
    return tile_.corrupt("an edge of the hull has one facet of it");
  }

  // Returns the next triangle around the edge v-u, such that only outside lies between the two; `none` where the
  // surface ends.
  Result<std::size_t> beside(std::size_t facet, std::int32_t v, std::int32_t u) const {
    std::int32_t cell = facets_[facet].cell;
    std::size_t corner = facets_[facet].corner;  // of the cell, opposite the facet that was crossed
    bool beyond = facets_[facet].outwards;       // whether that facet is crossed from the cell's inside
    while (true) {
      if (beyond) {
        const std::int32_t next = tile_.neighbor(cell, corner);
        if (next == SurfaceTile::outside) {
          if (!outside_beyond(cell, corner)) return number_of(cell, corner);
          BOOST_OUTCOME_TRY(other, other_hull_facet(v, u, cell, corner));
          cell = other.cell;
          corner = other.corner;
          if (!outside_beyond(cell, corner)) return none;
          if (!outside(cell)) return number_of(cell, corner);
        } else {
          if (next < 0) return tile_.corrupt("a facet with an own vertex has an unknown neighbour");
          BOOST_OUTCOME_TRY(back, tile_.corner_towards(next, cell));
          cell = next;
          corner = back;
          if (!outside(cell)) return number_of(cell, corner);
        }
      }
      // The cell is outside, and was entered opposite `corner`. It is left opposite the vertex that is neither v nor u.
      std::size_t out = none;
      for (std::size_t k = 0; k < 4; ++k)
        if (k != corner && tile_.vertex(cell, k) != v && tile_.vertex(cell, k) != u) out = k;
      if (out == none) return tile_.corrupt("a cell at an edge lacks the edge");
      corner = out;
      beyond = true;
    }
  }

  TriangleName name(const Leaf& leaf) const { return name_of(tile_, facets_[leaf.facet]); }

  static std::int32_t third(const Leaf& leaf, std::int32_t u) { return leaf.others[leaf.others[0] == u ? 1 : 0]; }

  // Moves a point a little towards the mean of some vertices. Sums are in the order of ids.
  Point a_little(Point from, std::vector<std::int32_t> to) const {
    std::ranges::sort(to, {}, [&](std::int32_t v) { return tile_.id(v); });
    const auto again = std::ranges::unique(to);
    to.erase(again.begin(), again.end());
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0;
      for (const std::int32_t v : to) sum += tile_.point(v)[axis];
      from[axis] += (sum / static_cast<double>(to.size()) - from[axis]) * off;
    }
    return from;
  }
  Point middle_of(std::int32_t v, std::int32_t u, std::int32_t first, std::int32_t second) const {
    const Point &p = tile_.point(v), &q = tile_.point(u);  // v has the lesser id
    return a_little({(p.x + q.x) / 2, (p.y + q.y) / 2, (p.z + q.z) / 2}, {first, second});
  }

  Status look_at(std::int32_t v, std::span<const Leaf> leaves) {
    std::vector<std::size_t> fan(leaves.size());  // a forest; each root is a fan
    std::iota(fan.begin(), fan.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
      while (fan[i] != i) i = fan[i] = fan[fan[i]];
      return i;
    };
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      for (const std::int32_t u : leaves[i].others) {
        BOOST_OUTCOME_TRY(facet, beside(leaves[i].facet, v, u));
        const auto found = std::ranges::find(leaves, facet, &Leaf::facet);
        const bool alone = found == leaves.end();  // the surface ends there, or was trimmed
        const std::size_t j = alone ? i : static_cast<std::size_t>(found - leaves.begin());
        fan[root(i)] = root(j);
        const auto at_edge =
            std::ranges::count_if(leaves, [&](const Leaf& leaf) { return std::ranges::count(leaf.others, u) > 0; });
        if (at_edge > (alone ? 1 : 2) && tile_.id(v) < tile_.id(u) && name(leaves[i]) <= name(leaves[j]))
          splits_.pairs.push_back({{tile_.id(v), tile_.id(u)},
                                   name(leaves[i]),
                                   name(leaves[j]),
                                   middle_of(v, u, third(leaves[i], u), third(leaves[j], u))});
      }
    }
    std::vector<std::pair<TriangleName, std::size_t>> least;  // by fan: its least triangle, and its root
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const auto at = std::ranges::find(least, root(i), &std::pair<TriangleName, std::size_t>::second);
      if (at == least.end()) {
        least.emplace_back(name(leaves[i]), root(i));
      } else {
        at->first = std::min(at->first, name(leaves[i]));
      }
    }
    if (least.size() == 1) return success();
    std::sort(least.begin(), least.end());
    for (std::uint32_t copy = 1; copy < least.size(); ++copy) {
      std::vector<std::int32_t> link;
      for (std::size_t i = 0; i < leaves.size(); ++i)
        if (root(i) == least[copy].second) link.insert(link.end(), leaves[i].others.begin(), leaves[i].others.end());
      splits_.places.push_back({tile_.id(v), copy, a_little(tile_.point(v), link)});
    }
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const auto at = std::ranges::find(least, root(i), &std::pair<TriangleName, std::size_t>::second);
      const auto copy = static_cast<std::uint32_t>(at - least.begin());
      if (copy > 0) splits_.corners.push_back({name(leaves[i]), tile_.id(v), copy});
    }
    return success();
  }

  const SurfaceTile& tile_;
  std::span<const Label> labels_;
  const CutRule& rule_;
  const Boundary& boundary_;
  std::span<const SurfaceFacet> facets_;
  std::vector<std::pair<std::uint64_t, std::size_t>> by_place_;
  Splits splits_;
};

}  // namespace

Result<Splits> splits_of(const SurfaceTile& tile, std::span<const Label> labels, const CutRule& rule,
                         const Boundary& boundary, std::span<const SurfaceFacet> facets) {
  return Umbrellas(tile, labels, rule, boundary, facets).find();
}

}  // namespace tessera::surface
