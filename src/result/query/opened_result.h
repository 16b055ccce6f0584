// A result that is open for queries: what all queries need of it.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/result/query/homes.h"
#include "src/result/query/part.h"
#include "src/result/query/stored_triangulation.h"
#include "src/result/query/tile_cache.h"
#include "src/result/query/walker.h"

namespace tessera::query {

// Thread-safe. The queries are functions beside it: star.h, cells.h, interpolate.h.
struct OpenedResult {
  OpenedResult(TileSource opened, Homes where, std::uint64_t bytes_max)
      : source(std::move(opened)),
        out(source.folder()),
        manifest(source.manifest()),
        homes(std::move(where)),
        cache(source, bytes_max),
        id_ranges(manifest.tiles.size()) {}
  TileSource source;
  const std::filesystem::path& out;  // its folder
  const Manifest& manifest;          // its manifest
  Homes homes;
  mutable TileCache cache;
  // The cells of a region; made when first asked for.
  mutable std::mutex tree_mutex;
  mutable std::unique_ptr<const CellTree> tree;
  Result<const CellTree*> part_tree() const;
  // The places of a periodic result that are those of the points, in its box. Other results: the points.
  std::vector<Point> in_box(std::span<const Point> points) const;
  // Error usage for a periodic result: `what` cannot be asked of it.
  Status refuse_periods(const std::string& what) const;
  // locate_all() and search() for a whole triangulation or a region.
  Status locate(const Batch& batch, const VisitLocated& visit) const;
  Result<Found> find(Walker& walker, const Area& area, std::uint64_t cells_max, const std::stop_token& stop) const;

  // By tile of the manifest: the least and the greatest source index of the tile's own vertices, once they were read.
  mutable std::mutex id_mutex;
  mutable std::vector<std::optional<std::pair<PointId, PointId>>> id_ranges;

  // Returns the tile that owns this vertex. Only the tiles' lists of source indices tell, so they are read until the
  // vertex is found.
  Result<std::optional<TileId>> owner_of(PointId id, const std::stop_token& stop) const;
};

// REQUIRES: the cell is main in the tile.
Cell cell_at(const CellRef& place);
Vertex vertex_at(const QueryTile& tile, std::int32_t vertex);

}  // namespace tessera::query
