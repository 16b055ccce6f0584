#include "src/result/verify/tile_check.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/geometry/predicates/independent/predicates.h"

namespace tessera {

namespace {

template <int D>
class TileCheck {
 public:
  TileCheck(const TileMesh& mesh, TileId tile, bool neighbors_stored, const TileSource& source, TileSinks& sinks)
      : mesh_(mesh), tile_(tile), neighbors_stored_(neighbors_stored), source_(source), sinks_(sinks) {}

  Status run(std::stop_token stop) {
    BOOST_OUTCOME_TRYV(check_vertices());
    std::vector<bool> used(mesh_.points.size(), false);
    // All cells are checked before all facets, because the best report of an inverted cell is that it is inverted.
    for (std::size_t c = 0; c < mesh_.cell_ghost.size(); ++c) {
      if (c % 65536 == 0 && stop.stop_requested()) return error(Errc::interrupted, "interrupted while verifying");
      BOOST_OUTCOME_TRYV(check_cell(c));
      for (int k = 0; k <= D; ++k) used[vertex(c, k)] = true;
    }
    for (std::size_t c = 0; c < mesh_.cell_ghost.size(); ++c) {
      if (c % 65536 == 0 && stop.stop_requested()) return error(Errc::interrupted, "interrupted while verifying");
      const bool own = all_own(c);
      for (int k = 0; k <= D; ++k) {
        BOOST_OUTCOME_TRYV(check_facet(c, k, own));
      }
    }
    if (const auto unused = std::find(used.begin(), used.end(), false); unused != used.end())
      return wrong_tile(
          source_, tile_,
          "vertex " + to_string(mesh_.ids[static_cast<std::size_t>(unused - used.begin())]) + " belongs to no cell");
    return success();
  }

 private:
  std::size_t vertex(std::size_t cell, int k) const {
    return static_cast<std::size_t>(mesh_.cells[cell * (D + 1) + static_cast<std::size_t>(k)]);
  }
  const Point& at(std::size_t cell, int k) const { return mesh_.points[vertex(cell, k)]; }
  bool is_own(std::size_t cell, int k) const { return mesh_.point_ghost[vertex(cell, k)] == 0; }
  bool all_own(std::size_t cell) const {
    bool own = true;
    for (int k = 0; k <= D; ++k) own = own && is_own(cell, k);
    return own;
  }
  std::int32_t neighbor(std::size_t cell, int k) const {
    return mesh_.neighbors[cell * (D + 1) + static_cast<std::size_t>(k)];
  }

  IdSet sorted_ids(std::size_t cell, int without = -1) const {
    IdSet ids{padding_id, padding_id, padding_id, padding_id};
    std::size_t n = 0;
    for (int k = 0; k <= D; ++k)
      if (k != without) ids[n++] = mesh_.ids[vertex(cell, k)];
    std::sort(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(n));
    return ids;
  }
  Error wrong(std::size_t cell, const std::string& reason) const {
    return wrong_cell(source_, {tile_, static_cast<std::uint32_t>(cell)}, sorted_ids(cell), reason);
  }
  std::string name(std::size_t cell) const {
    return "cell " + std::to_string(cell) + " (vertices " + text_of(sorted_ids(cell)) + ")";
  }

  // Own ids are compared with those of other tiles later. Foreign ids only need to differ within this file.
  Status check_vertices() {
    std::vector<PointId> foreign;
    for (std::size_t i = 0; i < mesh_.ids.size(); ++i) {
      if (mesh_.point_ghost[i] != 0) {
        foreign.push_back(mesh_.ids[i]);
      } else {
        BOOST_OUTCOME_TRYV(sinks_.own.push({mesh_.ids[i], tile_}));
      }
    }
    std::sort(foreign.begin(), foreign.end());
    if (const auto twice = std::adjacent_find(foreign.begin(), foreign.end()); twice != foreign.end())
      return wrong_tile(source_, tile_, "foreign vertex " + to_string(*twice) + " is there twice");
    return success();
  }

  Status check_cell(std::size_t c) {
    bool any_own = false;
    for (int k = 0; k <= D; ++k) any_own = any_own || is_own(c, k);
    const bool inner = all_own(c);
    if (!any_own) return wrong(c, "has no vertex of this tile");
    if (inner && mesh_.cell_ghost[c] != 0) return wrong(c, "is not main, though all its vertices are this tile's own");
    int orientation = 0;
    if constexpr (D == 2) orientation = independent::orientation_2(at(c, 0), at(c, 1), at(c, 2));
    if constexpr (D == 3) orientation = independent::orientation_3(at(c, 0), at(c, 1), at(c, 2), at(c, 3));
    if (orientation <= 0) return wrong(c, "is not positively oriented");
    if (inner) return success();
    return emit_copy(c);
  }

  Status emit_copy(std::size_t c) {
    std::array<int, D + 1> order;
    for (int k = 0; k <= D; ++k) order[static_cast<std::size_t>(k)] = k;
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return mesh_.ids[vertex(c, a)] < mesh_.ids[vertex(c, b)]; });
    CellCopy copy{};
    copy.ids = sorted_ids(c);
    copy.tile = tile_;
    copy.cell = static_cast<std::uint32_t>(c);
    copy.main = mesh_.cell_ghost[c] == 0 ? 1 : 0;
    std::array<Point, D + 1> points;
    for (std::size_t i = 0; i <= D; ++i) {
      points[i] = at(c, order[i]);
      if (is_own(c, order[i])) copy.own = static_cast<std::uint8_t>(copy.own | 1U << i);
    }
    copy.coordinates = checksum(std::as_bytes(std::span(points)));
    return sinks_.copies.push(copy);
  }

  Status check_facet(std::size_t c, int k, bool all_own) {
    bool judged_here = true, any_own = true;
    if (!all_own) {
      any_own = false;
      PointId least = padding_id;
      for (int i = 0; i <= D; ++i) {
        if (i == k) continue;
        any_own = any_own || is_own(c, i);
        if (mesh_.ids[vertex(c, i)] < least || least == padding_id) {
          least = mesh_.ids[vertex(c, i)];
          judged_here = is_own(c, i);
        }
      }
    }
    const std::int32_t n = neighbor(c, k);
    if (n >= 0) return check_pair(c, k, static_cast<std::size_t>(n), judged_here);
    if (n == -2 && any_own)
      return wrong(c, "has no neighbour opposite vertex " + to_string(mesh_.ids[vertex(c, k)]) +
                          ", though this tile would hold it");
    if (n == -1 && judged_here) {
      ++sinks_.facets;
      BOOST_OUTCOME_TRYV(emit_hull_facet(c, k));
      return emit_claim(c, k, Claim::on_hull);
    }
    if (!neighbors_stored_) return success();
    return emit_claim(c, k, n == -1 ? Claim::said_outside : Claim::said_elsewhere);
  }

  Status emit_claim(std::size_t c, int k, Claim claim) {
    return sinks_.claims.push({sorted_ids(c, k), tile_, static_cast<std::uint32_t>(c), claim});
  }

  Status emit_hull_facet(std::size_t c, int k) {
    HullFacet facet{};
    Core core{};
    core.ids = {padding_id, padding_id, padding_id, padding_id};
    facet.cell = {tile_, static_cast<std::uint32_t>(c)};
    std::size_t n = 0;
    for (int i = 0; i <= D; ++i) {
      core.at[static_cast<std::size_t>(i)] = at(c, i);
      core.ids[static_cast<std::size_t>(i)] = mesh_.ids[vertex(c, i)];
      if (i == k) continue;
      facet.at[n] = at(c, i);
      facet.ids[n++] = mesh_.ids[vertex(c, i)];
    }
    // Moving vertex k to the last place takes D - k swaps, and each swap inverts the cell.
    if ((D - k) % 2 != 0) {
      std::swap(facet.at[0], facet.at[1]);
      std::swap(facet.ids[0], facet.ids[1]);
    }
    return sinks_.hull.add(facet, core);
  }

  // Checks that cell n shares the facet of c opposite vertex k, names c as its neighbour, lies on the other side, and
  // has its vertex outside the sphere of c.
  Status check_pair(std::size_t c, int k, std::size_t n, bool judged_here) {
    int back = 0;  // index of c among the neighbours of n
    std::array<int, D + 1> place{};
    const auto says_so = [&](int j) {
      if (neighbor(n, j) != static_cast<std::int32_t>(c)) return false;
      for (int i = 0; i <= D; ++i) {
        place[static_cast<std::size_t>(i)] = j;
        if (i == k) continue;
        int found = 0;
        while (found <= D && (found == j || vertex(n, found) != vertex(c, i))) ++found;
        if (found > D) return false;
        place[static_cast<std::size_t>(i)] = found;
      }
      return true;
    };
    while (back <= D && !says_so(back)) ++back;
    if (back > D || n == c)
      return wrong(c, "names " + name(n) + " as its neighbour opposite vertex " + to_string(mesh_.ids[vertex(c, k)]) +
                          ", which does not share that facet or does not name it in turn");
    if (!judged_here || c > n) return success();

    ++sinks_.facets;
    // The cell c, with vertex k replaced by the vertex beyond, is this permutation of n. The permutation must be odd.
    int inversions = 0;
    for (std::size_t i = 0; i <= D; ++i)
      for (std::size_t j = 0; j < i; ++j) inversions += place[j] > place[i] ? 1 : 0;
    if (inversions % 2 == 0) return wrong(c, "lies on the same side of a facet as " + name(n));
    int inside = 0;
    if constexpr (D == 2) inside = independent::in_circle_perturbed_2(at(c, 0), at(c, 1), at(c, 2), at(n, back));
    if constexpr (D == 3)
      inside = independent::in_sphere_perturbed_3(at(c, 0), at(c, 1), at(c, 2), at(c, 3), at(n, back));
    if (inside >= 0)
      return wrong(c, std::string("is not Delaunay: vertex ") + to_string(mesh_.ids[vertex(n, back)]) + " of " +
                          name(n) + " is inside its circum" + (D == 2 ? "circle" : "sphere") +
                          ", or on it and the tie rule puts it inside");
    return success();
  }

  const TileMesh& mesh_;
  const TileId tile_;
  const bool neighbors_stored_;
  const TileSource& source_;
  TileSinks& sinks_;
};

Status check_claim_group(std::span<const FacetClaim> group, const TileSource& source) {
  const auto wrong = [&](const FacetClaim& claim, const std::string& reason) {
    return wrong_tile(
        source, claim.tile,
        "cell " + std::to_string(claim.cell) + " " + reason + " the facet of vertices " + text_of(claim.ids));
  };
  const bool on_hull = group[0].claim == Claim::on_hull;
  for (std::size_t i = 0; i < group.size(); ++i) {
    const FacetClaim& claim = group[i];
    const bool repeated = i > 0 && group[i - 1].claim == claim.claim && group[i - 1].tile == claim.tile;
    if (repeated && claim.claim != Claim::said_outside)
      return wrong(claim, "and cell " + std::to_string(group[i - 1].cell) + " do not name each other across");
    if (claim.claim == Claim::said_outside && !on_hull)
      return wrong(claim, "has neighbour -1 (outside) across a facet inside the hull:");
  }
  return success();
}

}  // namespace

Status check_tile(const TileMesh& mesh, TileId tile, bool neighbors_stored, const TileSource& source, TileSinks& sinks,
                  std::stop_token stop) {
  return mesh.dimension == 2 ? TileCheck<2>(mesh, tile, neighbors_stored, source, sinks).run(stop)
                             : TileCheck<3>(mesh, tile, neighbors_stored, source, sinks).run(stop);
}

Status check_claims(ExternalSort<FacetClaim>& claims, const TileSource& source) {
  return for_each_group(
      claims, 64, [](const FacetClaim& a, const FacetClaim& b) { return a.ids == b.ids; },
      [&](std::span<const FacetClaim> group) { return check_claim_group(group, source); });
}

}  // namespace tessera
