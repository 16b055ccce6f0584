// The Delaunay triangulation as a program of tiles. Messages are lists of points. When all is quiet, a tile has the
// cells of the whole cloud's triangulation that touch its points (src/tiling/tile/tile_triangulation.h).
#pragma once

#include <future>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/delaunay/delaunay_store.h"
#include "src/exchange/tile_program.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

// What all tiles of a job on one node have in common, read-only.
struct DelaunayStage final : TilePrograms {
  std::unique_ptr<TileProgram> program_of(TileId tile) const override;

  int dimension = 3;
  KernelKind kernel = KernelKind::flat;
  // Whether tiles hand out final cells and keep only the rest: that needs a tenth of the memory, and a tenth more work.
  bool reduce = false;
  // Whether tiles store cells. With points instead, final cells are counted and dropped as soon as they are known.
  TileKind kind = TileKind::cells;
  // Tiles of at least `early_points` points hand out final cells in any case. They store the early cells, a multiple of
  // `early_unit`, while other tiles are still triangulated. 0: no tile does. A tile's file depends on these two values,
  // not on when or by which process it is stored.
  std::uint64_t early_points = 0, early_unit = 1;
  // By tile. A tile with the empty box has no final cells, and announces nothing.
  std::shared_ptr<const std::vector<Box>> boxes;
  std::shared_ptr<const KnownFromStart> around;
  TileStorage* storage = nullptr;  // for what is kept beside the images
  DelaunayStore* store = nullptr;
  std::stop_token stop = {};  // once requested, long work soon throws Stopped
};

// The program of one tile. Not thread-safe; see TileProgram for the calls.
class DelaunayProgram final : public TileProgram {
 public:
  DelaunayProgram(TileId self, const DelaunayStage& stage) : self_(self), stage_(stage) {}

  Status begin() override { return build(true); }
  Status begin_settled(Message settled) override;
  Status take(TileId from, bool current, Message message) override;
  Status step() override;
  bool due() const override { return triangulation_->due(); }
  std::vector<std::pair<TileId, Message>> messages() override;
  void replay_to(std::span<const TileId> reborn) override { triangulation_->replay_to(reborn); }
  Status put_aside() override;
  Image save() override;
  Result<bool> load(Image image, ImageOf whose) override;
  Result<Image> pack(Image image) override;
  Result<bool> load_packed(Image packed) override;
  void free() override;
  Message settled() const override;
  Result<std::unique_ptr<Finished>> finish() override;
  std::size_t memory() const override;
  const ExchangeCounts& counts() const override { return counts_; }

 private:
  // What follows the triangulation in an image.
  struct ImageEnd {
    std::uint64_t own_points = 0;
    std::uint64_t of_points = 0;  // 1: the tile stores points, and its final cells are counted in `gone`
    CountedCells gone;
    std::uint64_t finals_sum = 0;  // checksum of the list of final cells that belongs to the image; 0: there is none
  };
  struct Heard {
    TileId from;
    SharedPoint point;
  };
  static std::uint64_t sum_of(const PendingFinals& finals);

  Status build(bool announce);
  Status insert();
  Status load_own_points();
  std::unique_ptr<TileTriangulation> decode(Image image, ImageEnd& end) const;
  Result<bool> wake(Image image);
  Result<bool> restore(Image image, const Image* finals, bool at_once);
  Status keep_finals(FinalCells finals, const LoadedTile& loaded, bool at_once);
  Status put_finals();
  Result<PendingFinals> take_finals();
  Status await_stored();
  bool decode_finals(std::span<const std::byte> bytes);
  Result<bool> restore_finals(std::span<const std::byte> bytes, bool at_once);
  // Counts and drops the final cells of a tile that stores points.
  void discard(const LoadedTile& loaded, const Box& box);
  Result<std::unique_ptr<Finished>> finish_points();
  bool keeps_cells() const { return stage_.kind == TileKind::cells; }
  bool early() const { return keeps_cells() && stage_.early_points > 0 && own_points_ >= stage_.early_points; }
  TileOptions options() const {
    return {self_, stage_.dimension, stage_.kernel, ExchangeRule::introduce, stage_.around.get(), stage_.stop};
  }

  TileId self_;
  const DelaunayStage& stage_;
  std::unique_ptr<TileTriangulation> triangulation_;
  std::vector<Heard> heard_;               // received, and not worked on yet
  std::unique_ptr<LoadedTile> points_;     // kept while the tile is whole in memory
  std::unique_ptr<PendingFinals> finals_;  // taken out of the triangulation; null: they are on scratch
  BigVector<std::byte> stored_early_;      // what the storage has returned for the early cells; belongs to finals_
  std::future<DelaunayStore::StoredEarly> storing_;  // will return stored_early_
  bool earlier_ = false;                             // the image on scratch is of an earlier life
  std::uint64_t own_points_ = 0;
  std::uint64_t finals_sum_ = 0;  // checksum of what is, or was, in finals_
  CountedCells gone_;             // cells that were dropped, all of them main
  ExchangeCounts counts_;
};

}  // namespace tessera
