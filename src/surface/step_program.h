// The program of a tile in a step whose messages follow from what earlier steps have kept. The tile sends everything at
// once, and works on what it has received when all is quiet. After a loss it sends the same pieces again.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/exchange/tile_program.h"
#include "src/surface/piece_mail.h"
#include "src/surface/step_store.h"

namespace tessera::surface {

// What is left of a tile at the end of a step.
class StepEnd final : public Finished {
 public:
  // `bytes` are written last: once they are there, the tile has finished the step.
  StepEnd(StepStore& store, StepOutput what, TileId tile, Bytes bytes)
      : store_(store), what_(what), tile_(tile), bytes_(std::move(bytes)) {}
  std::uint64_t bytes() const override { return bytes_.size(); }
  void store(Stored done) override;

 private:
  StepStore& store_;
  StepOutput what_;
  TileId tile_;
  Bytes bytes_;
};

// What tiles do in such a step. Thread-safe, for several tiles at once.
class StepWork {
 public:
  virtual ~StepWork() = default;
  // Adds all that the tile sends. Makes the same pieces at every call.
  virtual Status tell(TileId self, PieceOutbox& out) const = 0;
  // Returns what is kept of the tile for later steps. May first keep more in the store.
  virtual Result<Bytes> end(TileId self, const PieceInbox& told) const = 0;
};

class StepProgram final : public TileProgram {
 public:
  // `work` and `store` outlive the program.
  StepProgram(TileId self, const StepWork& work, StepStore& store, SurfaceStageId step)
      : self_(self), work_(work), store_(store), step_(step) {}

  Status begin() override { return tell({}); }
  Status begin_settled(Message settled) override;
  Status take(TileId from, bool current, Message message) override;
  Status step() override;
  bool due() const override { return !reborn_.empty(); }
  std::vector<std::pair<TileId, Message>> messages() override { return std::exchange(messages_, {}); }
  void replay_to(std::span<const TileId> reborn) override;
  Status put_aside() override { return success(); }
  Image save() override { return told_.save(); }
  Result<bool> load(Image image, ImageOf whose) override;
  Result<Image> pack(Image image) override { return image; }
  Result<bool> load_packed(Image packed) override { return load(std::move(packed), ImageOf::earlier); }
  void free() override;
  Message settled() const override { return told_.save(); }
  Result<std::unique_ptr<Finished>> finish() override;
  std::size_t memory() const override;
  const ExchangeCounts& counts() const override { return counts_; }

 private:
  // Sends to these tiles (ascending); empty: to all.
  Status tell(std::span<const TileId> to);

  TileId self_;
  const StepWork& work_;
  StepStore& store_;
  SurfaceStageId step_;
  PieceInbox told_;
  std::vector<TileId> reborn_;  // ascending
  std::vector<std::pair<TileId, Message>> messages_;
  ExchangeCounts counts_;
};

}  // namespace tessera::surface
