// The final cells of a tile in canonical order, so that the first cells can be written while the tile is still at work.
// Final cells that border cells of unknown neighbours come last.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/ids.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/cell_stream.h"
#include "src/tiling/tile/final_cells.h"
#include "src/tiling/tile/sorted_cells.h"

namespace tessera {

// Orders the final cells of a tile, and streams the early ones. Immutable once it is made.
class EarlyFinals final : public CellStream {
 public:
  // `ids`: of the tile's points. Of the final cells whose neighbours are all known, the largest multiple of `unit` is
  // early. Throws Stopped soon after `stop` is requested.
  EarlyFinals(int dimension, std::span<const PointId> ids, FinalCells cells, std::uint64_t unit,
              const std::stop_token& stop);

  std::span<const PointId> ids() const { return ids_; }
  std::uint64_t early() const { return early_; }
  std::uint64_t all() const { return cells_.rows.size(); }
  std::uint64_t others() const { return cells_.others; }  // cells of the tile that are not final
  // The early cells, as they will be in the mesh.
  Status vertices(const Consumer& take) const override;
  Status neighbors(const Consumer& take) const override;
  // Returns the final cells that are not early.
  PendingFinals left() const;

 private:
  SortedCells sorted(std::size_t first, std::size_t end) const;

  int dimension_;
  std::vector<PointId> ids_;  // a copy, as the cells may be written when the tile has gone
  FinalCells cells_;
  BigVector<std::uint32_t> order_;      // by number in the mesh: the row
  BigVector<std::int32_t> mesh_index_;  // as SortedCells::mesh_index, from the third entry on
  std::uint64_t early_ = 0;
};

}  // namespace tessera
