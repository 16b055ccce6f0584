// The Delaunay triangulation as a program of tiles. Messages are lists of points. When all is quiet, a tile has the
// cells of the whole cloud's triangulation that touch its points (src/tiling/tile/tile_triangulation.h).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/delaunay/delaunay_stage.h"
#include "src/delaunay/heard_points.h"
#include "src/delaunay/tile_finals.h"
#include "src/exchange/tile_program.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

// The program of one tile. Not thread-safe; see TileProgram for the calls.
class DelaunayProgram final : public TileProgram {
 public:
  DelaunayProgram(TileId self, const DelaunayStage& stage) : self_(self), stage_(stage), finals_(self, stage) {}

  Status begin() override { return build(true); }
  Status begin_settled(Message settled) override;
  Status take(TileId from, bool current, Message message) override;
  Status step() override;
  bool due() const override { return triangulation_->due(); }
  std::vector<std::pair<TileId, Message>> messages() override;
  void replay_to(std::span<const TileId> reborn) override { triangulation_->replay_to(reborn); }
  Status put_aside() override { return finals_.put_aside(); }
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

  Status build(bool announce);
  Status load_own_points();
  std::unique_ptr<TileTriangulation> decode(Image image, ImageEnd& end) const;
  Result<bool> wake(Image image);
  Result<bool> restore(Image image, const Image* finals, bool at_once);
  // Counts and drops the final cells of a tile that stores points.
  void discard(const LoadedTile& loaded, const Box& box);
  Result<std::unique_ptr<Finished>> finish_points();
  bool keeps_cells() const { return stage_.kind == TileKind::cells; }
  TileOptions options() const {
    return {self_, stage_.dimension, stage_.kernel, ExchangeRule::introduce, stage_.around.get(), stage_.stop};
  }

  TileId self_;
  const DelaunayStage& stage_;
  std::unique_ptr<TileTriangulation> triangulation_;
  HeardPoints heard_;                   // received, and not worked on yet
  std::unique_ptr<LoadedTile> points_;  // kept while the tile is whole in memory
  TileFinals finals_;
  bool earlier_ = false;  // the image on scratch is of an earlier life
  std::uint64_t own_points_ = 0;
  CountedCells gone_;  // cells that were dropped, all of them main
  ExchangeCounts counts_;
};

}  // namespace tessera
