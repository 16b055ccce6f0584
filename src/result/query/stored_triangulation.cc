#include "src/result/query/stored_triangulation.h"

#include <utility>

#include "src/result/query/batch.h"
#include "src/result/query/impl.h"

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
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  return open(std::move(source), options);
}

Result<StoredTriangulation> StoredTriangulation::open(TileSource source, const OpenOptions& options) {
  const std::filesystem::path& out = source.folder();
  const Manifest& manifest = source.manifest();
  if (manifest.region && !options.parts)
    return error(Errc::usage, out.string() +
                                  ": holds a region of a triangulation: beside its cells nothing is known of what is "
                                  "asked; triangulate all points, or export its cells");
  if (manifest.region && manifest.tiles.size() != 1)
    return error(Errc::corrupt, out.string() + ": is a region that has not one tile");
  BOOST_OUTCOME_TRY(homes, Homes::of(out, manifest));
  return StoredTriangulation(std::make_unique<Impl>(std::move(source), std::move(homes), options.memory_bytes));
}

const TileSource& StoredTriangulation::source() const { return impl_->source; }
const Manifest& StoredTriangulation::manifest() const { return impl_->manifest; }
std::uint64_t StoredTriangulation::tiles_read() const { return impl_->cache.loads(); }

bool StoredTriangulation::knows(const Bounds& box) const { return query::knows(impl_->manifest, box); }

Result<const CellTree*> StoredTriangulation::Impl::part_tree() const {
  const std::lock_guard lock(tree_mutex);
  if (!tree) {
    BOOST_OUTCOME_TRY(tile, cache.get(manifest.tiles.front().tile, false));
    tree = std::make_unique<const CellTree>(*tile);
  }
  return tree.get();
}

Status StoredTriangulation::Impl::locate(const Batch& batch, const VisitLocated& visit) const {
  if (!manifest.region) return locate_all(cache, manifest, homes, batch, visit);
  BOOST_OUTCOME_TRY(cells, part_tree());
  return locate_all_in_part(cache, manifest, *cells, batch, visit);
}

Result<Found> StoredTriangulation::Impl::find(Walker& walker, const Area& area, std::uint64_t cells_max,
                                              const std::stop_token& stop) const {
  if (!manifest.region) return search(walker, homes, manifest, area, cells_max, stop);
  BOOST_OUTCOME_TRY(cells, part_tree());
  return search_part(walker, manifest, *cells, area, cells_max, stop);
}

Result<std::vector<Cell>> StoredTriangulation::locate(std::span<const Point> points, const AskOptions& options) const {
  std::vector<Cell> cells(points.size());
  const Batch batch{.points = points, .threads = options.threads, .stop = options.stop};
  const auto visit = [&](Walker& walker, std::size_t i, const Located& located) -> Status {
    cells[i].final = located.final;
    if (!located.place) return success();
    BOOST_OUTCOME_TRY(main, walker.main_place(located.place));
    cells[i] = cell_at(main);
    cells[i].final = located.final;
    return success();
  };
  BOOST_OUTCOME_TRYV(impl_->locate(batch, visit));
  return cells;
}

Result<CellDetails> StoredTriangulation::details(const Cell& cell) const {
  Walker walker(impl_->cache, impl_->manifest, false);
  BOOST_OUTCOME_TRY(tile, walker.tile(cell.tile));
  const Place place{tile, cell.cell};
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

}  // namespace tessera::query
