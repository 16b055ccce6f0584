#include "src/result/verify/tile_check.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/image.h"
#include "src/base/periodic_box.h"
#include "src/geometry/predicates/independent/predicates.h"

namespace tessera {

namespace {

template <int D>
class TileCheck {
 public:
  TileCheck(const TileMesh& mesh, TileId tile, bool neighbors_stored, const TileSource& source, TileSinks& sinks)
      : mesh_(mesh),
        tile_(tile),
        neighbors_stored_(neighbors_stored),
        source_(source),
        period_(source.period()),
        sinks_(sinks) {}

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

  PeriodOffset offset(std::size_t v) const {
    return mesh_.offsets.empty() ? PeriodOffset{} : image::offset(mesh_.offsets[v]);
  }
  // Whether one vertex is less than another, by id and then by offset. The order does not change by shifts.
  bool is_less(std::size_t v, std::size_t w) const {
    return mesh_.ids[v] != mesh_.ids[w] ? mesh_.ids[v] < mesh_.ids[w] : offset(v) < offset(w);
  }
  // The least of the cell's vertices, but for one.
  int least(std::size_t cell, int without = -1) const {
    int least = without == 0 ? 1 : 0;
    for (int k = least + 1; k <= D; ++k)
      if (k != without && is_less(vertex(cell, k), vertex(cell, least))) least = k;
    return least;
  }
  // The vertex, in the copy of the cell or facet in which the least one has the offset 0.
  PointId shifted_id(std::size_t v, const PeriodOffset& of_least) const {
    return mesh_.offsets.empty() ? mesh_.ids[v] : image_of(mesh_.ids[v], offset(v) - of_least);
  }

  IdSet sorted_ids(std::size_t cell, int without = -1) const {
    IdSet ids{padding_id, padding_id, padding_id, padding_id};
    const PeriodOffset of_least = offset(vertex(cell, least(cell, without)));
    std::size_t n = 0;
    for (int k = 0; k <= D; ++k)
      if (k != without) ids[n++] = shifted_id(vertex(cell, k), of_least);
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
        foreign.push_back(shifted_id(i, {}));
      } else {
        BOOST_OUTCOME_TRYV(sinks_.own.push({mesh_.ids[i], tile_}));
        if (sinks_.space) sinks_.space->add_vertex(mesh_.points[i]);
      }
      if (sinks_.space && !is_in_place(i))
        return wrong_tile(source_, tile_,
                          "vertex " + to_string(mesh_.ids[i]) +
                              " does not lie whole periods from a place in the box that shifts do not round");
    }
    std::sort(foreign.begin(), foreign.end());
    if (const auto twice = std::adjacent_find(foreign.begin(), foreign.end()); twice != foreign.end())
      return wrong_tile(source_, tile_, "foreign vertex " + text_of(*twice) + " is there twice");
    return success();
  }

  // Whether all shifts of the vertex by periods are exact.
  bool is_in_place(std::size_t v) const {
    const PeriodOffset o = offset(v);
    const Point at = period_.shifted(mesh_.points[v], PeriodOffset{} - o);
    bool in_place = period_.shifted(at, o) == mesh_.points[v];
    for (int axis = 0; axis < D; ++axis) {
      if (period_.along(axis))
        in_place = in_place && is_in_period(at[axis], period_.length[static_cast<std::size_t>(axis)]);
    }
    return in_place;
  }

  // Whether the offsets of the cell's vertices are near each other.
  bool is_short(std::size_t c) const {
    for (int k = 0; k <= D; ++k) {
      for (int i = 0; i < k; ++i)
        if (!(offset(vertex(c, k)) - offset(vertex(c, i))).near()) return false;
    }
    return true;
  }

  Status check_cell(std::size_t c) {
    if (!mesh_.offsets.empty() && !is_short(c)) return wrong(c, "has an edge that is longer than a period");
    bool any_own = false;
    for (int k = 0; k <= D; ++k) any_own = any_own || is_own(c, k);
    const bool inner = all_own(c);
    if (!any_own) return wrong(c, "has no vertex of this tile");
    if (inner && mesh_.cell_ghost[c] != 0) return wrong(c, "is not main, though all its vertices are this tile's own");
    int orientation = 0;
    if constexpr (D == 2) orientation = independent::orientation_2(at(c, 0), at(c, 1), at(c, 2));
    if constexpr (D == 3) orientation = independent::orientation_3(at(c, 0), at(c, 1), at(c, 2), at(c, 3));
    if (orientation <= 0) return wrong(c, "is not positively oriented");
    if (sinks_.space && mesh_.cell_ghost[c] == 0) {
      std::array<Point, D + 1> corners;
      for (int k = 0; k <= D; ++k) corners[static_cast<std::size_t>(k)] = at(c, k);
      sinks_.space->add_main_cell(corners);
    }
    if (inner) return success();
    return emit_copy(c);
  }

  Status emit_copy(std::size_t c) {
    std::array<int, D + 1> order;
    for (int k = 0; k <= D; ++k) order[static_cast<std::size_t>(k)] = k;
    const PeriodOffset of_least = offset(vertex(c, least(c)));
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return shifted_id(vertex(c, a), of_least) < shifted_id(vertex(c, b), of_least); });
    CellCopy copy{};
    copy.first = is_first_copy(c) ? 1 : 0;
    copy.ids = sorted_ids(c);
    copy.tile = tile_;
    copy.cell = static_cast<std::uint32_t>(c);
    copy.main = mesh_.cell_ghost[c] == 0 ? 1 : 0;
    std::array<Point, D + 1> points;
    for (std::size_t i = 0; i <= D; ++i) {
      points[i] = period_.shifted(at(c, order[i]), PeriodOffset{} - of_least);
      if (is_own(c, order[i])) copy.own = static_cast<std::uint8_t>(copy.own | 1U << i);
    }
    copy.coordinates = checksum(std::as_bytes(std::span(points)));
    return sinks_.copies.push(copy);
  }

  // Whether the least offset of the tile's own points in the cell is 0. Of the copies that a tile has, one is first.
  bool is_first_copy(std::size_t c) const {
    for (int k = 0; k <= D; ++k)
      if (mesh_.owners[vertex(c, k)] == tile_ && offset(vertex(c, k)) < PeriodOffset{}) return false;
    return true;
  }

  Status check_facet(std::size_t c, int k, bool all_own) {
    bool judged_here = true, any_own = true;
    if (!all_own) {
      any_own = false;
      for (int i = 0; i <= D; ++i) any_own = any_own || (i != k && is_own(c, i));
      judged_here = is_own(c, least(c, k));
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
    const auto copy = static_cast<std::uint8_t>(image::code(offset(vertex(c, least(c, k)))));
    return sinks_.claims.push({sorted_ids(c, k), tile_, static_cast<std::uint32_t>(c), claim, copy});
  }

  Status emit_hull_facet(std::size_t c, int k) {
    if (sinks_.space) {
      std::array<Point, D> corners;
      std::size_t n = 0;
      for (int i = 0; i <= D; ++i)
        if (i != k) corners[n++] = at(c, i);
      return sinks_.space->add_hull_facet(corners, {tile_, static_cast<std::uint32_t>(c)}, sorted_ids(c));
    }
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
  const Period& period_;
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
    const bool repeated = i > 0 && group[i - 1].claim == claim.claim && group[i - 1].tile == claim.tile &&
                          group[i - 1].copy == claim.copy;
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
