// Small results made by hand: a triangulation of one kernel, cut into tiles by slabs. Tests damage them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/store/tile_reader.h"
#include "src/result/store/tile_store.h"

namespace tessera::test {

enum class Shape { uniform, lattice, sphere, terrain };

// Distinct points; lattice and terrain have many cospherical ones. `n` is a target: a lattice has at least as many.
std::vector<Point> sample_points(Shape shape, int dimension, std::size_t n, unsigned seed = 1);

// The triangulation of `points` (ids are their ranks) as `tiles` slabs along x would store it.
std::vector<TileMesh> sample_tiles(const std::vector<Point>& points, int dimension, std::uint32_t tiles);
// The same with any tile for each point, by its place.
std::vector<TileMesh> sample_tiles(const std::vector<Point>& points, int dimension, std::uint32_t tiles,
                                   const std::function<std::uint32_t(std::size_t)>& tile_of);

// The attributes of a tile's vertices.
using RowsOf = std::function<std::vector<std::byte>(const TileMesh&)>;

// Writes meshes (tile i is meshes[i]; empty ones are left out) and all that belongs to a result. Attributes are some
// bytes unless `rows_of` says which; tiles are kept as points if `kind_of` says so.
Manifest store_sample(const std::filesystem::path& out, const std::vector<TileMesh>& meshes,
                      const StoreOptions& options = {}, const std::vector<DuplicatePair>& duplicates = {},
                      const RowsOf& rows_of = {}, const std::function<TileKind(TileId)>& kind_of = {});

// The tile of a result that has no versions, without a look at its manifest.
inline Result<StoredTile> read_tile(const std::filesystem::path& out, TileId tile, bool with_rows = false) {
  return store::read_tile(tile_file(out, tile), tile, {.rows = with_rows});
}

// An empty folder of its own, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace tessera::test
