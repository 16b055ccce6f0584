// The second stage of a change: the exchange by which the tiles of a stored result get the cells of the changed points
// (docs/updates-design.md). Only a tile with fresh points begins. Other tiles hold nothing, and are read and
// triangulated when a message comes for them.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/delaunay/heard_points.h"
#include "src/delaunay/update/update_store.h"
#include "src/exchange/tile_program.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

// The program of one tile. Not thread-safe; see TileProgram for the calls.
class ChangedProgram final : public TileProgram {
 public:
  ChangedProgram(TileId self, std::shared_ptr<const UpdateSetting> setting)
      : self_(self), setting_(std::move(setting)) {}

  Status begin() override;
  Status begin_settled(Message settled) override;
  Status take(TileId from, bool current, Message message) override;
  Status step() override;
  bool due() const override { return triangulation_ && triangulation_->due(); }
  std::vector<std::pair<TileId, Message>> messages() override;
  void replay_to(std::span<const TileId> reborn) override {
    if (triangulation_) triangulation_->replay_to(reborn);
  }
  Status put_aside() override { return success(); }
  Image save() override;
  Result<bool> load(Image image, ImageOf whose) override;
  Result<Image> pack(Image image) override { return image; }
  Result<bool> load_packed(Image packed) override;
  void free() override;
  Message settled() const override;
  Result<std::unique_ptr<Finished>> finish() override;
  std::size_t memory() const override;
  const ExchangeCounts& counts() const override { return counts_; }

 private:
  // Ends an image, and what the tile has settled.
  struct LastPart {
    std::uint64_t built = 0, begun = 0, lost = 0, reshaped = 0;
    ExchangeCounts counts;
  };
  LastPart last_part() const {
    return {triangulation_ ? 1u : 0u, begun_ ? 1u : 0u, lost_ ? 1u : 0u, reshaped_ ? 1u : 0u, counts_};
  }
  // Takes the last part off `bytes`. Returns false when there is none.
  static bool take_last_part(BigVector<std::byte>& bytes, LastPart& last);
  void go_by(const LastPart& last);
  TileOptions options() const;
  // Whether the change names the tile.
  Result<bool> concerns() const;
  Status read(bool cells);
  Status build();
  Status check_span() const;

  TileId self_;
  std::shared_ptr<const UpdateSetting> setting_;
  std::unique_ptr<TileTriangulation> triangulation_;  // null: nothing has woken the tile, or it sleeps
  std::unique_ptr<StartOfTile> start_;                // kept while the tile is whole in memory
  HeardPoints heard_;
  bool begun_ = false, lost_ = false, reshaped_ = false;
  bool earlier_ = false;  // the image on scratch is of an earlier life
  ExchangeCounts counts_;
};

}  // namespace tessera
