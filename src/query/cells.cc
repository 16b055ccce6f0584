#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>

#include "src/base/option.h"
#include "src/query/impl.h"
#include "src/query/search.h"
#include "src/verify/match_facets.h"

namespace tessera::query {
namespace {

// Copies cells out of tiles, and of their vertices each once.
class Collector {
 public:
  Collector(const Manifest& manifest, std::size_t cells) : row_bytes_(tessera::row_bytes(manifest.schema)) {
    set_.mesh.mesh.dimension = manifest.dimension;
    set_.mesh.schema = manifest.schema;
    set_.tiles.reserve(cells);
  }

  void add(const QueryTile& tile, std::int32_t cell) {
    TileMesh& mesh = set_.mesh.mesh;
    for (std::size_t k = 0; k < tile.corners(); ++k) {
      const std::int32_t v = tile.vertex(cell, k);
      const auto [at, is_new] = numbers_.emplace(tile.id_of(v).value, static_cast<std::int32_t>(mesh.points.size()));
      mesh.cells.push_back(at->second);
      if (!is_new) continue;
      mesh.points.push_back(tile.point(v));
      mesh.ids.push_back(tile.id_of(v));
      mesh.owners.push_back(tile.owner(v));
      mesh.point_ghost.push_back(0);
      if (row_bytes_ > 0) set_.mesh.rows.insert(set_.mesh.rows.end(), tile.row(v), tile.row(v) + row_bytes_);
    }
    mesh.cell_ghost.push_back(0);
    if (!tile.mesh().cell_final.empty()) mesh.cell_final.push_back(tile.is_final(cell) ? 1 : 0);
    set_.tiles.push_back(tile.id());
  }
  CellSet take() { return std::move(set_); }

 private:
  std::size_t row_bytes_;
  CellSet set_;
  std::unordered_map<std::uint64_t, std::int32_t> numbers_;  // by source index
};

}  // namespace

Result<CellSet> StoredTriangulation::cells(const Area& area, const CellLimits& limits,
                                           const AskOptions& options) const {
  const Manifest& manifest = impl_->manifest;
  const bool with_rows = !manifest.schema.empty();
  Walker walker(impl_->cache, manifest, with_rows);
  // A cell with its corners, neighbours and tile, and most likely one vertex or less with its attributes.
  const std::uint64_t bytes_each = 64 + sizeof(Point) + 40 + row_bytes(manifest.schema);
  const std::uint64_t fit = limits.bytes_max / bytes_each, most = std::min(limits.cells_max, fit);
  BOOST_OUTCOME_TRY(found, impl_->find(walker, area, most, options.stop));
  if (found.count > most && limits.cells_max < fit)
    return error(Errc::memory, impl_->out.string() + ": the area has more than " + std::to_string(limits.cells_max) +
                                   " cells, which is the limit: give a smaller area");
  if (found.count > most)
    return error(Errc::memory, impl_->out.string() + ": the area has more than " + std::to_string(fit) +
                                   " cells, which take " + std::to_string(limits.bytes_max >> 20) +
                                   " MiB of memory: give more " + option("memory") + ", or a smaller area");
  Collector collector(manifest, found.count);
  for (auto& [id, cells] : found.cells) {
    walker.keep_only(nullptr);
    BOOST_OUTCOME_TRY(tile, walker.tile(id));
    std::sort(cells.begin(), cells.end());
    for (const std::int32_t cell : cells) collector.add(*tile, cell);
  }
  CellSet set = collector.take();
  set.final = knows(area.box);
  BOOST_OUTCOME_TRYV(match_facets(set.mesh.mesh, TileId{0}, impl_->out));
  return set;
}

Result<std::vector<TileId>> StoredTriangulation::tiles(const Area& area, const AskOptions& options) const {
  Walker walker(impl_->cache, impl_->manifest, false);
  BOOST_OUTCOME_TRY(found, impl_->find(walker, area, ~std::uint64_t{0}, options.stop));
  return std::vector<TileId>(found.owners.begin(), found.owners.end());
}

}  // namespace tessera::query
