// What a StoredTriangulation consists of.
#pragma once

#include <filesystem>

#include "src/query/homes.h"
#include "src/query/stored_triangulation.h"
#include "src/query/tile_cache.h"
#include "src/query/walker.h"

namespace tessera::query {

struct StoredTriangulation::Impl {
  Impl(std::filesystem::path folder, Manifest read, Homes where, std::uint64_t bytes_max)
      : out(std::move(folder)), manifest(std::move(read)), homes(std::move(where)), cache(out, manifest, bytes_max) {}
  std::filesystem::path out;
  Manifest manifest;
  Homes homes;
  mutable TileCache cache;
};

// REQUIRES: the cell is main in the tile.
Cell cell_at(const Place& place);
Vertex vertex_at(const QueryTile& tile, std::int32_t vertex);

}  // namespace tessera::query
