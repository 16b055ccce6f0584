// A tile's mesh whose cells are still where the kernel had them: as arrays they would need as much memory again, and
// fresh pages cost more than to turn and translate cells when they are written.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/big_vector.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/cell_stream.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/tile/sorted_cells.h"

namespace tessera {

// Its first cells may have been written before: they are not among these.
struct CollectedTile final : CellStream {
  TileMesh mesh;                // without cells and neighbors
  std::uint64_t early = 0;      // how many were written before
  BigVector<std::byte> stored;  // what the storage has said of them
  CellRows rows;
  BigVector<std::uint32_t> order;          // of the rows that are the other cells of the mesh, as in SortedCells
  std::vector<std::uint32_t> index;        // as there
  BigVector<std::int32_t> places{-2, -1};  // as there, from the third on; before it what lies across no facet: itself
  std::uint32_t own = 0;

  Status vertices(const Take& take) const override;
  Status neighbors(const Take& take) const override;
  // With all arrays. Of cells that were written before: `vertices` and `neighbors`.
  TileMesh whole(std::span<const std::int32_t> vertices = {}, std::span<const std::int32_t> neighbors = {}) &&;
  std::uint64_t bytes() const;
  // Valid as long as nothing here is assigned to.
  SortedCells sorted() const;
};

}  // namespace tessera
