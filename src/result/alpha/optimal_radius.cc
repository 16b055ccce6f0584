// A piece begins with a cell, at the cell's circumradius, and two pieces become one at the greater circumradius of the
// two cells of a facet. So the number of pieces at R is the number of cells with a circumradius up to R, less the
// number of edges up to R in a minimum spanning forest of the graph of cells and facets (Kruskal).
//
// A facet belongs to its main tile. A tile joins cells by its own facets, in ascending order. Where one of the two
// pieces has no cell with a facet of another tile, no other edge can take the place of this one: it is in the forest.
// Otherwise it goes to the end, where the edges of all tiles are joined in the same way. In a periodic result a tile
// may have several copies of a cell, which are one cell; they all have a vertex that is not the tile's own, so they
// meet at the end, where all copies have the same name.
#include "src/result/alpha/optimal_radius.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/disjoint_sets.h"
#include "src/base/stopped.h"
#include "src/geometry/mesh/images.h"
#include "src/geometry/predicates/exact/circumradius.h"
#include "src/result/alpha/tile_alpha.h"
#include "src/result/store/external_sort.h"
#include "src/result/tile_queue.h"

namespace tessera::alpha {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// At `radius` the number of pieces changes.
struct Change {
  double radius = 0;
  std::int64_t pieces = 0;
  friend bool operator<(const Change& a, const Change& b) {
    return a.radius != b.radius ? a.radius < b.radius : a.pieces < b.pieces;
  }
};

using CellIdSet = std::array<PointId, 4>;

// An end of an edge that goes to the end.
struct SharedEnd {
  CellIdSet cell{};
  std::uint64_t place = 0;  // twice the rank of the edge, plus 0 or 1
  friend bool operator<(const SharedEnd& a, const SharedEnd& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.place < b.place;
  }
};

struct SharedEdge {
  double radius = 0;
  std::array<std::uint32_t, 2> cells{};
};

// What one tile knows.
class TileRadii {
 public:
  TileRadii(const TileMesh& mesh, TileId self, const std::stop_token& stop)
      : mesh_(mesh), self_(self), corners_(static_cast<std::size_t>(mesh.dimension) + 1) {
    std::array<Point, 4> at;
    radii_.resize(mesh.cell_ghost.size());
    for (std::size_t cell = 0; cell < radii_.size(); ++cell) {
      if (cell % 4096 == 0 && stop.stop_requested()) throw Stopped();
      for (std::size_t k = 0; k < corners_; ++k)
        at[k] = mesh.points[static_cast<std::size_t>(mesh.cells[cell * corners_ + k])];
      radii_[cell] = exact::circumradius_up(std::span(at).first(corners_), corners_ == 3);
    }
  }

  // The least radius at which all own vertices are in the shape.
  double covering() const {
    std::vector<double> least(mesh_.points.size(), infinite);
    for (std::size_t i = 0; i < mesh_.cells.size(); ++i) {
      double& at = least[static_cast<std::size_t>(mesh_.cells[i])];
      at = std::min(at, radii_[i / corners_]);
    }
    double most = 0;
    for (std::size_t v = 0; v < least.size(); ++v)
      if (mesh_.point_ghost[v] == 0) most = std::max(most, least[v]);
    return most;
  }

  // Returns the changes, sorted, at most one for a radius; and calls share(cell, cell, radius) for edges that other
  // tiles may replace.
  template <class Share>
  Result<std::vector<Change>> join(const Share& share) const {
    std::vector<Change> changes;
    for (std::size_t cell = 0; cell < radii_.size(); ++cell)
      if (mesh_.cell_ghost[cell] == 0) changes.push_back({radii_[cell], 1});
    std::vector<std::uint8_t> alone = alone_cells();   // by root: whether no cell of the piece is shared
    std::vector<std::uint32_t> shared(radii_.size());  // by root: one of its shared cells
    std::iota(shared.begin(), shared.end(), 0U);
    DisjointSets pieces(radii_.size());
    for (const Edge& edge : sorted_edges()) {
      const std::uint32_t a = pieces.find(edge.a), b = pieces.find(edge.b);
      if (a == b) continue;
      if (alone[a] != 0 || alone[b] != 0) {
        changes.push_back({edge.radius, -1});
      } else {
        BOOST_OUTCOME_TRYV(share(ids_of(shared[a]), ids_of(shared[b]), edge.radius));
      }
      const std::uint32_t kept = alone[a] == 0 ? shared[a] : shared[b];
      const std::uint8_t both = alone[a] & alone[b];
      const std::uint32_t root = pieces.join(a, b);
      shared[root] = kept;
      alone[root] = both;
    }
    std::sort(changes.begin(), changes.end());
    std::size_t size = 0;
    for (const Change& change : changes) {
      if (size > 0 && changes[size - 1].radius == change.radius) {
        changes[size - 1].pieces += change.pieces;
      } else {
        changes[size++] = change;
      }
    }
    changes.resize(size);
    std::erase_if(changes, [](const Change& change) { return change.pieces == 0; });
    return changes;
  }

 private:
  struct Edge {
    double radius = 0;
    std::uint32_t a = 0, b = 0;
  };

  std::vector<std::uint8_t> alone_cells() const {
    std::vector<std::uint8_t> alone(radii_.size(), 1);
    for (std::size_t i = 0; i < mesh_.cells.size(); ++i)
      if (mesh_.point_ghost[static_cast<std::size_t>(mesh_.cells[i])] != 0) alone[i / corners_] = 0;
    return alone;
  }
  std::vector<Edge> sorted_edges() const {
    std::vector<Edge> edges;
    for (std::size_t cell = 0; cell < radii_.size(); ++cell) {
      for (std::size_t k = 0; k < corners_; ++k) {
        const std::int32_t neighbor = mesh_.neighbors[cell * corners_ + k];
        if (neighbor < 0 || static_cast<std::size_t>(neighbor) < cell) continue;
        const auto facet = facet_of(mesh_, cell, k);
        if (!is_main(mesh_, std::span(facet).first(corners_ - 1), self_)) continue;
        edges.push_back({std::max(radii_[cell], radii_[static_cast<std::size_t>(neighbor)]),
                         static_cast<std::uint32_t>(cell), static_cast<std::uint32_t>(neighbor)});
      }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.radius < b.radius; });
    return edges;
  }
  // The same for all copies of a cell.
  CellIdSet ids_of(std::uint32_t cell) const {
    CellIdSet ids{};
    for (std::size_t k = 0; k < corners_; ++k) ids[k] = image_of(mesh_, mesh_.cells[cell * corners_ + k], {});
    sort_up_to_shifts(std::span(ids).first(corners_));
    return ids;
  }

  const TileMesh& mesh_;
  TileId self_;
  std::size_t corners_;
  std::vector<double> radii_;
};

// What is known of all tiles together.
class Pieces {
 public:
  Pieces(const RadiusSearch& search)
      : changes_(search.scratch, search.memory_bytes / 8, search.stop),
        ends_(search.scratch, search.memory_bytes / 8, search.stop) {}

  Status add(const TileMesh& mesh, TileId self, const std::stop_token& stop) {
    const TileRadii radii(mesh, self, stop);
    const double covering = radii.covering();
    BOOST_OUTCOME_TRY(changes, radii.join([&](const CellIdSet& a, const CellIdSet& b, double radius) -> Status {
      const std::lock_guard lock(mutex_);
      BOOST_OUTCOME_TRYV(ends_.push({a, 2 * edges_.size()}));
      BOOST_OUTCOME_TRYV(ends_.push({b, 2 * edges_.size() + 1}));
      edges_.push_back({radius, {}});
      return success();
    }));
    const std::lock_guard lock(mutex_);
    covering_ = std::max(covering_, covering);
    for (const Change& change : changes) {
      BOOST_OUTCOME_TRYV(changes_.push(change));
    }
    return success();
  }

  // The answer, after all tiles.
  Result<double> least() {
    BOOST_OUTCOME_TRYV(join_tiles());
    std::int64_t pieces = 0;
    double at = 0;  // `pieces` are those of this radius, when all changes up to it have been counted
    std::optional<double> found;
    BOOST_OUTCOME_TRYV(changes_.for_each([&](const Change& change) -> Status {
      if (!found && change.radius > at && at >= covering_ && pieces == 1) found = at;
      if (!found && change.radius > covering_ && at < covering_ && pieces == 1) found = covering_;
      at = change.radius;
      pieces += change.pieces;
      return success();
    }));
    if (!found && pieces == 1) found = std::max(at, covering_);
    if (!found) return error(Errc::corrupt, "the cells of the result do not hang together");
    return *found;
  }

 private:
  Status join_tiles() {
    std::uint32_t cells = 0;
    std::optional<CellIdSet> last;
    BOOST_OUTCOME_TRYV(ends_.for_each([&](const SharedEnd& end) -> Status {
      if (last != end.cell) ++cells;
      last = end.cell;
      edges_[end.place / 2].cells[end.place % 2] = cells - 1;
      return success();
    }));
    std::sort(edges_.begin(), edges_.end(),
              [](const SharedEdge& a, const SharedEdge& b) { return a.radius < b.radius; });
    DisjointSets sets(cells);
    for (const SharedEdge& edge : edges_) {
      const std::uint32_t a = sets.find(edge.cells[0]), b = sets.find(edge.cells[1]);
      if (a == b) continue;
      sets.join(a, b);
      BOOST_OUTCOME_TRYV(changes_.push({edge.radius, -1}));
    }
    return success();
  }

  std::mutex mutex_;
  ExternalSort<Change> changes_;
  ExternalSort<SharedEnd> ends_;
  std::vector<SharedEdge> edges_;
  double covering_ = 0;
};

}  // namespace

Result<double> optimal_radius(const TileSource& source, const RadiusSearch& search) {
  // Radii, edges and changes of a tile.
  constexpr double tile_factor = 4;
  Pieces pieces(search);
  BOOST_OUTCOME_TRYV(for_each_tile(source,
                                   {.threads = search.threads,
                                    .memory_bytes = search.memory_bytes / 2,
                                    .tile_factor = tile_factor,
                                    .stop = search.stop,
                                    .progress = search.progress},
                                   [&](const TileSource& from, std::size_t index) -> Status {
                                     BOOST_OUTCOME_TRY(tile, from.read(index, {}));
                                     return pieces.add(tile.mesh, from.entry(index).tile, search.stop);
                                   }));
  BOOST_OUTCOME_TRY(radius, pieces.least());
  if (!std::isfinite(radius))
    return error(Errc::bad_input,
                 source.folder().string() + ": only cells whose circumradius is too large for a double make one piece");
  return radius;
}

}  // namespace tessera::alpha
