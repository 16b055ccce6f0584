#include "src/result/query/stored_triangulation.h"

#include <utility>

#include "src/result/query/batch.h"
#include "src/result/query/cells.h"
#include "src/result/query/interpolate.h"
#include "src/result/query/opened_result.h"
#include "src/result/query/star.h"

namespace tessera::query {

StoredTriangulation::StoredTriangulation(std::unique_ptr<OpenedResult> result) : result_(std::move(result)) {}
StoredTriangulation::StoredTriangulation(StoredTriangulation&&) noexcept = default;
StoredTriangulation::~StoredTriangulation() = default;

Result<StoredTriangulation> StoredTriangulation::open(const std::filesystem::path& out, const OpenOptions& options) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out, options.periods));
  return open(std::move(source), options);
}

Result<StoredTriangulation> StoredTriangulation::open(TileSource source, const OpenOptions& options) {
  const std::filesystem::path& out = source.folder();
  const Manifest& manifest = source.manifest();
  if (manifest.region && !options.parts)
    return error(Errc::usage,
                 out.string() +
                     ": holds a region of a triangulation, and what lies around its cells is unknown, so it answers "
                     "no queries; triangulate all points, or export the cells of the region");
  if (manifest.region && manifest.tiles.size() != 1)
    return error(Errc::corrupt, out.string() + ": is a region, so it must have one tile, but it has " +
                                    std::to_string(manifest.tiles.size()));
  BOOST_OUTCOME_TRY(homes, Homes::of(out, manifest));
  return StoredTriangulation(std::make_unique<OpenedResult>(std::move(source), std::move(homes), options.memory_bytes));
}

const TileSource& StoredTriangulation::source() const { return result_->source; }
const Manifest& StoredTriangulation::manifest() const { return result_->manifest; }
std::uint64_t StoredTriangulation::tiles_read() const { return result_->cache.loads(); }

bool StoredTriangulation::knows(const Bounds& box) const { return query::knows(result_->manifest, box); }

Result<std::vector<Cell>> StoredTriangulation::locate(std::span<const Point> points, const AskOptions& options) const {
  std::vector<Cell> cells(points.size());
  const std::vector<Point> asked = result_->in_box(points);
  const Batch batch{.points = asked, .threads = options.threads, .stop = options.stop};
  const auto visit = [&](Walker& walker, std::size_t i, const Located& located) -> Status {
    cells[i].final = located.final;
    if (!located.place) return success();
    BOOST_OUTCOME_TRY(main, walker.main_place(located.place));
    cells[i] = cell_at(main);
    cells[i].final = located.final;
    return success();
  };
  BOOST_OUTCOME_TRYV(result_->locate(batch, visit));
  return cells;
}

Result<CellDetails> StoredTriangulation::details(const Cell& cell) const {
  Walker walker(result_->cache, result_->manifest, false);
  BOOST_OUTCOME_TRY(tile, walker.tile(cell.tile));
  const CellRef place{tile, cell.cell};
  CellDetails details{.cell = cell, .vertices = {}, .neighbors = {}};
  for (std::size_t k = 0; k < tile->corners(); ++k) {
    details.vertices.push_back(vertex_at(*tile, tile->vertex(cell.cell, k)));
    walker.forget_doubts();
    BOOST_OUTCOME_TRY(beyond, walker.across(place, k));
    Cell neighbor;
    if (beyond) {
      BOOST_OUTCOME_TRY(main, walker.main_place(beyond));
      neighbor = cell_at(main);
    }
    neighbor.final = !walker.met_unknown() && !walker.met_unsure();
    details.neighbors.push_back(neighbor);
  }
  return details;
}

Result<Star> StoredTriangulation::star(PointId id, std::optional<TileId> owner, const AskOptions& options) const {
  return star_of(*result_, id, owner, options);
}

Result<Neighbours> StoredTriangulation::neighbours(PointId id, std::optional<TileId> owner,
                                                   const AskOptions& options) const {
  return neighbours_of(*result_, id, owner, options);
}

Result<CellSet> StoredTriangulation::cells(const Area& area, const CellLimits& limits,
                                           const AskOptions& options) const {
  return cells_of(*result_, area, limits, options);
}

Result<HullCells> StoredTriangulation::hull(const CellLimits& limits, const AskOptions& options,
                                            std::optional<double> max_edge, std::optional<double> max_radius) const {
  return hull_of(*result_, limits, options, max_edge, max_radius);
}

Result<Cell> StoredTriangulation::cell(TileId tile, std::int32_t place) const { return cell_of(*result_, tile, place); }

Result<std::vector<TileId>> StoredTriangulation::tiles(const Area& area, const AskOptions& options) const {
  return tiles_of(*result_, area, options);
}

Result<std::vector<Interpolated>> StoredTriangulation::interpolate(std::span<const Point> points,
                                                                   const InterpolateOptions& what,
                                                                   const AskOptions& options) const {
  return interpolated(*result_, points, what, options);
}

}  // namespace tessera::query
