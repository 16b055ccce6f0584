// The program of a tile in the step rays. It casts the rays of its own vertices, and continues rays that come from
// other tiles. What a ray does in a tile depends on the ray alone, so a tile that gets a ray again recognises it by its
// vertex, its side and its number of steps.
#pragma once

#include <compare>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "src/exchange/tile_program.h"
#include "src/surface/kept_codec.h"
#include "src/surface/records.h"
#include "src/surface/steps.h"

namespace tessera::surface {

class RayCaster;

class RaysProgram final : public TileProgram {
 public:
  // `store` outlives the program.
  RaysProgram(TileId self, std::shared_ptr<const StepInput> input, StepStore& store)
      : self_(self), input_(std::move(input)), store_(store) {}

  Status begin() override;
  Status begin_settled(Message settled) override;
  Status take(TileId from, bool current, Message message) override;
  Status step() override;
  bool due() const override { return false; }
  std::vector<std::pair<TileId, Message>> messages() override;
  void replay_to(std::span<const TileId> reborn) override;
  Status put_aside() override;
  Image save() override;
  Result<bool> load(Image image, ImageOf whose) override;
  Result<Image> pack(Image image) override { return image; }
  Result<bool> load_packed(Image packed) override { return load(std::move(packed), ImageOf::earlier); }
  void free() override;
  Message settled() const override;
  Result<std::unique_ptr<Finished>> finish() override;
  std::size_t memory() const override;
  const ExchangeCounts& counts() const override { return counts_; }

 private:
  // A ray that has arrived: from this vertex, on this side, after so many steps.
  struct Known {
    PointId of;
    std::uint64_t steps = 0;
    std::uint32_t behind = 0, unused = 0;
    friend auto operator<=>(const Known&, const Known&) = default;
  };
  struct Sent {
    RayRecord ray;
    TileId to;
    std::uint32_t unused = 0;
  };
  Status cast();
  void send(RayCaster& caster);
  Status wake();
  SurfaceTile::Weights weights() const;

  TileId self_;
  std::shared_ptr<const StepInput> input_;
  StepStore& store_;
  std::unique_ptr<SurfaceTile> tile_;  // null: put aside
  SurfaceTile::Weights put_aside_;     // of the tile that was put aside
  RayCounts sums_;
  std::set<Known> known_;
  std::vector<RayRecord> waiting_;
  std::vector<Sent> sent_;
  std::size_t told_ = 0;            // how many of sent_ have been sent
  std::vector<std::size_t> again_;  // which of these are to be sent again
  ExchangeCounts counts_;
};

}  // namespace tessera::surface
