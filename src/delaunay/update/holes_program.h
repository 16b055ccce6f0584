// The first stage of a change: the owners of removed points tell the tiles around the holes.
//
// A tile finds the points that are affected by a removal in its own cells, but only if it knows that it has to look. So
// the owner of a removed point tells all tiles that have a vertex in a cell with that point.
//
// Besides, where points were removed at a border, a tile no longer knows what is beyond. It would take far points for
// its neighbours, and wake tile after tile. So each tile that begins knows the points around the holes from the start.
//
// A hole is filled when one tile owns all of its removed points: each tile beside the hole is told all points around,
// and has its cells from them alone. Where all holes are filled and no points are added, there is no exchange.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "src/delaunay/update/update_store.h"
#include "src/exchange/tile_program.h"

namespace tessera {

class HolesProgram final : public TileProgram {
 public:
  // A tile tells at most so many points around its holes, spread evenly; and of each filled hole at most so many.
  static constexpr std::size_t points_max = 4096;

  HolesProgram(TileId self, std::shared_ptr<const UpdateSetting> setting) : self_(self), setting_(std::move(setting)) {}

  Status begin() override { return tell({}); }
  Status begin_settled(Message settled) override;
  Status take(TileId from, bool current, Message message) override;
  Status step() override;
  bool due() const override { return !reborn_.empty(); }
  std::vector<std::pair<TileId, Message>> messages() override { return std::exchange(messages_, {}); }
  void replay_to(std::span<const TileId> reborn) override;
  Status put_aside() override { return success(); }
  Image save() override { return settled(); }
  Result<bool> load(Image image, ImageOf whose) override;
  Result<Image> pack(Image image) override { return image; }
  Result<bool> load_packed(Image packed) override { return load(std::move(packed), ImageOf::earlier); }
  void free() override;
  Message settled() const override;
  Result<std::unique_ptr<Finished>> finish() override;
  std::size_t memory() const override;
  const ExchangeCounts& counts() const override { return counts_; }

 private:
  // Tells these tiles (ascending); empty: all.
  Status tell(std::span<const TileId> to);
  ToldOfHoles told() const;
  bool add(std::span<const std::byte> bytes);

  TileId self_;
  std::shared_ptr<const UpdateSetting> setting_;
  bool beside_ = false;
  std::map<PointId, SharedPoint> around_;
  std::set<PointId> filled_;
  std::vector<TileId> reborn_;  // ascending
  std::vector<std::pair<TileId, Message>> messages_;
  ExchangeCounts counts_;
};

}  // namespace tessera
