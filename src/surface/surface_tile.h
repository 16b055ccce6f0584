// A tile of a triangulation on its way to a surface: its cells, and what rays have said of them so far.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/surface/energy.h"

namespace tessera::surface {

// The name of a cell in all tiles: the source indices of its vertices, ascending.
using CellName = std::array<PointId, 4>;
// The corners of the facet opposite each corner of a positively oriented cell, counterclockwise as seen from outside.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> facet_corners{{{1, 2, 3}, {0, 3, 2}, {3, 0, 1}, {2, 1, 0}}};

class SurfaceTile {
 public:
  static constexpr std::int32_t outside = -1, elsewhere = -2;  // values of neighbor(): beyond the hull; in another tile

  // `name`: the tile's file, for errors. Error corrupt when it is not a tile in 3D with neighbours.
  static Result<SurfaceTile> make(TileId self, std::string name, StoredTile stored);

  TileId self() const { return self_; }
  const TileMesh& mesh() const { return stored_.mesh; }
  const StoredTile& stored() const { return stored_; }
  std::int32_t cells() const { return static_cast<std::int32_t>(mesh().cell_ghost.size()); }
  std::int32_t own_vertices() const { return own_; }  // numbered from 0
  std::int32_t vertex(std::int32_t cell, std::size_t corner) const {
    return mesh().cells[4 * static_cast<std::size_t>(cell) + corner];
  }
  std::int32_t neighbor(std::int32_t cell, std::size_t corner) const {
    return mesh().neighbors[4 * static_cast<std::size_t>(cell) + corner];
  }
  const Point& point(std::int32_t vertex) const { return mesh().points[static_cast<std::size_t>(vertex)]; }
  PointId id(std::int32_t vertex) const { return mesh().ids[static_cast<std::size_t>(vertex)]; }
  TileId owner(std::int32_t vertex) const { return mesh().owners[static_cast<std::size_t>(vertex)]; }
  Corner corner(std::int32_t vertex) const { return {point(vertex), id(vertex)}; }
  bool is_main(std::int32_t cell) const { return mesh().cell_ghost[static_cast<std::size_t>(cell)] == 0; }

  CellName name(std::int32_t cell) const;
  // Returns the main tile of the cell, the lowest that owns a vertex of it; and likewise of a facet.
  TileId main_tile(std::int32_t cell) const;
  TileId main_tile(std::int32_t cell, std::size_t facet) const;
  std::array<Corner, 3> facet(std::int32_t cell, std::size_t opposite) const;
  // Returns which corner of the cell has this id. Error corrupt when none has.
  Result<std::size_t> corner_of(std::int32_t cell, PointId id) const;
  // Returns the corner of a cell opposite the facet across which the cell `from` is. Error corrupt when the two cells
  // contradict each other.
  Result<std::size_t> corner_towards(std::int32_t cell, std::int32_t from) const;

  // Returns the cells around an own vertex.
  std::span<const std::uint32_t> star(std::int32_t own_vertex) const;
  // Returns the scale of an own vertex, from the median of the lengths of its edges.
  double scale_of(std::int32_t own_vertex);
  void forget_marks() { marked_ = {}; }  // frees what scale_of() keeps between calls
  // Returns the cell of this name. Error corrupt when there is no such cell, or when none of its vertices is the tile's
  // own.
  Result<std::int32_t> find(const CellName& name) const;

  // What rays add to: the arc out of a cell across a facet, and the excess of a cell.
  std::uint32_t& arc(std::int32_t cell, std::size_t facet) { return arcs_[4 * static_cast<std::size_t>(cell) + facet]; }
  std::uint32_t arc(std::int32_t cell, std::size_t facet) const {
    return arcs_[4 * static_cast<std::size_t>(cell) + facet];
  }
  std::int64_t& excess(std::int32_t cell) { return excess_[static_cast<std::size_t>(cell)]; }
  void begin_weights();
  void forget_weights();  // frees the weights
  bool has_weights() const { return !excess_.empty(); }
  struct Weights {
    BigVector<std::uint32_t> arcs;
    BigVector<std::int64_t> excess;
  };
  Weights weights() const { return {arcs_, excess_}; }
  Weights take_weights();  // moves them out
  // Error corrupt when the weights are not of the same number of cells.
  Status put_weights(Weights weights);

  // Save the tile to a file, and load it back, without weights.
  Status save_cells(const std::filesystem::path& file) const;
  static Result<SurfaceTile> load_cells(TileId self, std::string name, const std::filesystem::path& file,
                                        const std::vector<Attribute>& schema);
  std::size_t bytes() const;

  Error corrupt(const std::string& reason) const;

 private:
  SurfaceTile(TileId self, std::string name, StoredTile stored);
  Status index();

  TileId self_;
  std::string name_;
  StoredTile stored_;
  std::int32_t own_ = 0;
  BigVector<std::uint32_t> star_first_, star_cells_;  // by own vertex
  std::vector<std::int32_t> by_id_;                   // own vertices
  BigVector<std::uint32_t> arcs_;
  BigVector<std::int64_t> excess_;
  std::vector<std::int32_t> marked_;  // by vertex: 1 + the last own vertex whose edges were looked at
};

}  // namespace tessera::surface
