// A tile's mesh whose cells are still where the kernel had them. As arrays the cells would need as much memory again,
// and fresh pages cost more time than to turn and translate the cells while they are written.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/big_vector.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/cell_stream.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/sorted_cells.h"

namespace tessera {

// A tile that is ready to be written. Its first cells may have been written early; then they are not among these cells.
struct CollectedTile final : CellStream {
  TileMesh mesh;                // without cells and neighbors
  std::uint64_t early = 0;      // how many cells were written early
  BigVector<std::byte> stored;  // what the storage has returned for the early cells
  CellRecords rows;
  BigVector<std::uint32_t> order;    // of the rows that are the other cells of the mesh, as in SortedCells
  std::vector<std::uint32_t> index;  // as in SortedCells
  // as SortedCells::mesh_index, from the third entry on; the two before it stand for facets without a neighbour
  BigVector<std::int32_t> mesh_index{-2, -1};
  std::uint32_t own = 0;

  Status vertices(const Consumer& take) const override;
  Status neighbors(const Consumer& take) const override;
  // Returns the mesh with all arrays. `vertices`, `neighbors`: those of the cells that were written early.
  TileMesh whole(std::span<const std::int32_t> vertices = {}, std::span<const std::int32_t> neighbors = {}) &&;
  std::uint64_t bytes() const;
  // Valid until a member is changed.
  SortedCells sorted() const;
};

}  // namespace tessera
