// What a StoredTriangulation consists of.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/result/query/homes.h"
#include "src/result/query/part.h"
#include "src/result/query/stored_triangulation.h"
#include "src/result/query/tile_cache.h"
#include "src/result/query/walker.h"

namespace tessera::query {

struct StoredTriangulation::Impl {
  Impl(TileSource opened, Homes where, std::uint64_t bytes_max)
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
  // Of a part of a triangulation; made when it is first asked.
  mutable std::mutex tree_mutex;
  mutable std::unique_ptr<const CellTree> tree;
  Result<const CellTree*> part_tree() const;
  // locate_all() and search(), of either kind.
  Status locate(const Batch& batch, const VisitLocated& visit) const;
  Result<Found> find(Walker& walker, const Area& area, std::uint64_t cells_max, const std::stop_token& stop) const;

  // By the manifest's tiles: the least and the greatest source index of their own vertices, once they were read.
  mutable std::mutex id_mutex;
  mutable std::vector<std::optional<std::pair<PointId, PointId>>> id_ranges;

  // The tile whose own vertex this is. Nothing says it but the tiles: their lists of indices are read until it is
  // found.
  Result<std::optional<TileId>> owner_of(PointId id, const std::stop_token& stop) const;
};

// REQUIRES: the cell is main in the tile.
Cell cell_at(const Place& place);
Vertex vertex_at(const QueryTile& tile, std::int32_t vertex);

}  // namespace tessera::query
