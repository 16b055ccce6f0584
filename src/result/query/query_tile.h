// A tile of a result in memory, with what queries need: where a walk begins, and the cells around a vertex.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "src/base/image.h"
#include "src/base/result.h"
#include "src/geometry/mesh/images.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/tile_source.h"
#include "src/tiling/hilbert.h"

namespace tessera::query {

// The vertices of a cell, sorted: the same in every tile that has the cell. They are images (src/base/image.h), which
// are source indices where no period is between a vertex and its point. In 2D the last is no_id.
using CellIds = std::array<PointId, 4>;
inline constexpr PointId no_id{~std::uint64_t{0}};

// Constant once loaded, so threads may share it.
class QueryTile {
 public:
  // Reads the source's `index`-th tile, and finds the neighbours of its cells if the result was stored without them.
  // Errors: those of TileSource::read(); not_delaunay when three cells share a facet; memory.
  static Result<std::shared_ptr<const QueryTile>> load(const TileSource& source, std::size_t index, bool with_rows);

  TileId id() const { return id_; }
  const TileMesh& mesh() const { return stored_.mesh; }
  std::size_t corners() const { return static_cast<std::size_t>(mesh().dimension) + 1; }
  std::size_t bytes() const { return bytes_; }  // in memory
  bool has_rows() const { return with_rows_; }
  // The attributes of a vertex. REQUIRES: has_rows(), and the schema is not empty.
  const std::byte* row(std::int32_t vertex) const {
    return stored_.rows.data() + static_cast<std::size_t>(vertex) * row_bytes_;
  }

  std::int32_t vertex(std::int32_t cell, std::size_t corner) const {
    return mesh().cells[static_cast<std::size_t>(cell) * corners() + corner];
  }
  std::int32_t neighbor(std::int32_t cell, std::size_t corner) const {
    return mesh().neighbors[static_cast<std::size_t>(cell) * corners() + corner];
  }
  const Point& point(std::int32_t vertex) const { return mesh().points[static_cast<std::size_t>(vertex)]; }
  PointId id_of(std::int32_t vertex) const { return mesh().ids[static_cast<std::size_t>(vertex)]; }
  PeriodOffset offset(std::int32_t vertex) const { return offset_of(mesh(), vertex); }
  // The image that a vertex is after a shift back by `base`.
  PointId image(std::int32_t vertex, const PeriodOffset& base = {}) const { return image_of(mesh(), vertex, base); }
  const Period& period() const { return period_; }
  TileId owner(std::int32_t vertex) const { return mesh().owners[static_cast<std::size_t>(vertex)]; }
  // The cell's vertices after a shift back by `base`.
  CellIds ids(std::int32_t cell, const PeriodOffset& base = {}) const;
  // The same for all copies of a cell, in all tiles.
  CellIds name(std::int32_t cell) const {
    CellIds found = ids(cell);
    sort_up_to_shifts(std::span(found).first(corners()));
    return found;
  }
  // The tile in which the cell is main: the lowest that owns a vertex of it.
  TileId main_tile(std::int32_t cell) const;

  // The key of a point along a Hilbert curve through this tile. Keys of different tiles are unrelated.
  std::uint64_t key(const Point& p) const { return key_(p); }
  // A cell near q; `key` is q's key. `from` is where the last search ended, when keys are asked for in ascending order;
  // 0 at first.
  std::int32_t start(const Point& q, std::uint64_t key, std::size_t& from) const;

  // The tile's own vertex with this source index, or -1.
  std::int32_t own_vertex(PointId id) const;
  // All cells around this own vertex. Error corrupt when the neighbours contradict the cells.
  Result<std::vector<std::int32_t>> around(std::int32_t own_vertex) const;
  // The cell with these vertices, or -1. Error corrupt as in around(), and when the tile owns none of the vertices.
  Result<std::int32_t> find(const CellIds& ids) const;

  // is_part() is true for a region, where a neighbour may be unknown. is_final() says whether the cell is surely a cell
  // of the whole triangulation.
  bool is_part() const { return part_; }
  bool is_final(std::int32_t cell) const {
    return mesh().cell_final.empty() || mesh().cell_final[static_cast<std::size_t>(cell)] != 0;
  }

  // Error corrupt with this tile's file: "out/tiles/000042.vtu, cell 17: `reason`".
  Error corrupt_cell(std::int32_t cell, const std::string& reason) const;

 private:
  QueryTile(std::filesystem::path path, const TileEntry& entry, StoredTile stored, const Period& period, bool with_rows,
            bool part);

  std::filesystem::path path_;
  TileId id_;
  StoredTile stored_;
  Period period_;
  bool with_rows_, part_;
  std::size_t row_bytes_;
  HilbertKey key_;
  std::vector<std::pair<std::uint64_t, std::int32_t>> samples_;  // (key of its first vertex, cell), ascending
  std::vector<std::int32_t> cell_of_;                            // by vertex: a cell with the vertex, or -1
  // Own vertices by id. Sorted when first asked for, because most queries are answered within one tile.
  mutable std::once_flag by_id_made_;
  mutable std::vector<std::int32_t> by_id_;
  std::size_t bytes_ = 0;
};

}  // namespace tessera::query
