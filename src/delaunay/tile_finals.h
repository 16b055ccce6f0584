// The final cells of one tile, from the moment when its triangulation hands them out until the tile is collected. Some
// of them may be stored early. The others wait in memory or on scratch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <span>

#include "src/base/big_vector.h"
#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/delaunay/delaunay_stage.h"
#include "src/delaunay/delaunay_store.h"
#include "src/tiling/tile/final_cells.h"

namespace tessera {

// Not thread-safe. Refers to the stage, which must outlive this object. `own_points` is the number of points that the
// tile owns. `at_once`: the tile is collected next, so its cells need not go to scratch.
class TileFinals {
 public:
  TileFinals(TileId self, const DelaunayStage& stage) : self_(self), stage_(stage) {}

  // Forgets the cells, and what is known of those on scratch. The tile is built next.
  void clear();
  // Takes the final cells of the tile. `ids`: of the tile's points. May begin to store the early ones.
  Status keep(FinalCells finals, std::span<const PointId> ids, bool at_once);
  // Returns the error of storing the early cells, if it is known by now. Does not wait.
  Status stored_so_far();
  // Writes the cells in memory to scratch, and frees them.
  Status put_aside();
  // Returns the cells that were not stored early. Error corrupt when scratch is damaged.
  Result<PendingFinals> take(std::uint64_t own_points);
  // Waits until the early cells are stored. Returns what the storage has returned for them.
  Result<BigVector<std::byte>> take_stored();

  // Restores the cells of an earlier process, or of another node, from the bytes that put_aside() wrote. Returns false
  // when the tile cannot continue from them. REQUIRES: expect() was called.
  Result<bool> restore(std::span<const std::byte> bytes, std::uint64_t own_points, bool at_once);
  // The checksum of the list that is, or was, in memory; 0: there is none. An image of the tile names it, and expect()
  // sets it from the image.
  std::uint64_t sum() const { return sum_; }
  void expect(std::uint64_t sum) { sum_ = sum; }

  // Frees the cells in memory.
  void free() { finals_.reset(); }
  std::size_t memory() const { return finals_ ? finals_->bytes() : 0; }

 private:
  static std::uint64_t sum_of(const PendingFinals& finals);
  Status await_stored();
  bool decode(std::span<const std::byte> bytes, std::uint64_t own_points);

  TileId self_;
  const DelaunayStage& stage_;
  std::unique_ptr<PendingFinals> finals_;            // null: there are none, or they are on scratch
  BigVector<std::byte> stored_early_;                // what the storage has returned for the early cells of finals_
  std::future<DelaunayStore::StoredEarly> storing_;  // will return stored_early_
  std::uint64_t sum_ = 0;
};

}  // namespace tessera
