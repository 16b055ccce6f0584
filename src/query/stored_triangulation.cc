#include "src/query/stored_triangulation.h"

#include <utility>

#include "src/query/batch.h"
#include "src/query/impl.h"

namespace tessera::query {

Cell cell_at(const Place& place) {
  Cell cell{.tile = place.tile->id(), .cell = place.cell};
  for (std::size_t k = 0; k < place.tile->corners(); ++k)
    cell.vertices[k] = place.tile->id_of(place.tile->vertex(place.cell, k));
  return cell;
}

Vertex vertex_at(const QueryTile& tile, std::int32_t vertex) {
  return {.id = tile.id_of(vertex), .owner = tile.owner(vertex), .at = tile.point(vertex)};
}

StoredTriangulation::StoredTriangulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StoredTriangulation::StoredTriangulation(StoredTriangulation&&) noexcept = default;
StoredTriangulation::~StoredTriangulation() = default;

Result<StoredTriangulation> StoredTriangulation::open(const std::filesystem::path& out, const OpenOptions& options) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  if (manifest.region)
    return error(Errc::usage, out.string() +
                                  ": holds a region of a triangulation: beside its cells nothing is known of what is "
                                  "asked; triangulate all points, or export its cells");
  BOOST_OUTCOME_TRY(homes, Homes::of(out, manifest));
  return StoredTriangulation(std::make_unique<Impl>(out, std::move(manifest), std::move(homes), options.memory_bytes));
}

const Manifest& StoredTriangulation::manifest() const { return impl_->manifest; }
std::uint64_t StoredTriangulation::tiles_read() const { return impl_->cache.loads(); }

Result<std::vector<Cell>> StoredTriangulation::locate(std::span<const Point> points, const AskOptions& options) const {
  std::vector<Cell> cells(points.size());
  const Batch batch{.points = points, .threads = options.threads, .stop = options.stop};
  const auto visit = [&](Walker& walker, std::size_t i, const Located& located) -> Status {
    if (!located.place) return success();
    BOOST_OUTCOME_TRY(main, walker.main_place(located.place));
    cells[i] = cell_at(main);
    return success();
  };
  BOOST_OUTCOME_TRYV(locate_all(impl_->cache, impl_->manifest, impl_->homes, batch, visit));
  return cells;
}

Result<CellDetails> StoredTriangulation::details(const Cell& cell) const {
  Walker walker(impl_->cache, impl_->manifest, false);
  BOOST_OUTCOME_TRY(tile, walker.tile(cell.tile));
  const Place place{tile, cell.cell};
  CellDetails details{.cell = cell, .vertices = {}, .neighbors = {}};
  for (std::size_t k = 0; k < tile->corners(); ++k) {
    details.vertices.push_back(vertex_at(*tile, tile->vertex(cell.cell, k)));
    BOOST_OUTCOME_TRY(beyond, walker.across(place, k));
    Cell neighbor;
    if (beyond) {
      BOOST_OUTCOME_TRY(main, walker.main_place(beyond));
      neighbor = cell_at(main);
    }
    details.neighbors.push_back(neighbor);
  }
  return details;
}

}  // namespace tessera::query
