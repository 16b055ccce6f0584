// A program that is no triangulation: each tile learns the greatest number among its own, its neighbours' and theirs.
// What the machine does for one program it does for any.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "src/base/flat_codec.h"
#include "src/exchange/tile_program.h"

namespace tessera::testing {

struct GreatestStage final : TilePrograms {
  std::unique_ptr<TileProgram> program_of(TileId tile) const override;
  std::function<Result<std::vector<TileId>>(TileId)> neighbours;  // ascending, by what the stage before has left
  std::function<std::uint64_t(TileId)> number;
  std::function<Status(TileId, std::uint64_t)> keep = [](TileId, std::uint64_t) { return success(); };
};

struct GreatestFound final : Finished {
  GreatestFound(TileId t, std::uint64_t n, const GreatestStage& s) : tile(t), number(n), stage(s) {}
  std::uint64_t bytes() const override { return sizeof number; }
  void store(Stored done) override {
    FlatWriter receipt;
    receipt.value(number);
    Status kept = stage.keep(tile, number);
    done(kept ? Result<Receipt>(receipt.take()) : Result<Receipt>(std::move(kept).error()));
  }
  TileId tile;
  std::uint64_t number;
  const GreatestStage& stage;
};

// A message is a number, and whether it is to be passed on.
class Greatest final : public TileProgram {
 public:
  Greatest(TileId self, const GreatestStage& stage) : self_(self), stage_(stage) {}

  Status begin() override {
    BOOST_OUTCOME_TRYV(look_around());
    known_ = {stage_.number(self_), 0};
    for (const TileId to : neighbours_) tell(to, known_.greatest, true);
    return success();
  }
  Status begin_settled(Message settled) override {
    return read(settled) ? Status(success()) : damaged(self_, "number");
  }
  Status take(TileId, bool, Message message) override {
    if (message.empty()) return success();  // the tile's call to itself
    FlatReader in(message);
    auto& [number, pass_on] = taken_.emplace_back();
    return in.value(number) && in.value(pass_on) ? Status(success()) : error(Errc::internal, "no number");
  }
  Status step() override {
    for (const auto& [number, pass_on] : std::exchange(taken_, {})) {
      known_.greatest = std::max(known_.greatest, number);
      if (pass_on == 0 || number <= known_.passed_on) continue;
      known_.passed_on = number;
      for (const TileId to : neighbours_) tell(to, number, false);
    }
    return success();
  }
  bool due() const override { return false; }
  std::vector<std::pair<TileId, Message>> messages() override { return std::exchange(messages_, {}); }
  void replay_to(std::span<const TileId> reborn) override {
    for (const TileId to : neighbours_)
      if (std::binary_search(reborn.begin(), reborn.end(), to)) tell_again(to);
  }

  Status put_aside() override { return success(); }
  Image save() override { return settled(); }
  Result<bool> load(Image image, ImageOf whose) override {
    BOOST_OUTCOME_TRYV(look_around());
    if (!read(image)) return false;
    for (const TileId to : neighbours_)
      if (whose != ImageOf::sleeper) tell_again(to);
    return true;
  }
  Result<Image> pack(Image image) override { return image; }
  Result<bool> load_packed(Image packed) override { return load(std::move(packed), ImageOf::earlier); }
  void free() override { known_ = {}; }

  Message settled() const override {
    FlatWriter out;
    out.value(known_);
    return out.take();
  }
  Result<std::unique_ptr<Finished>> finish() override {
    return std::unique_ptr<Finished>(std::make_unique<GreatestFound>(self_, known_.greatest, stage_));
  }
  std::size_t memory() const override { return sizeof *this; }
  const ExchangeCounts& counts() const override { return counts_; }

 private:
  struct Known {
    std::uint64_t greatest = 0, passed_on = 0;
  };
  Status look_around() {
    BOOST_OUTCOME_TRY(found, stage_.neighbours(self_));
    neighbours_ = std::move(found);
    return success();
  }
  bool read(const Image& image) {
    FlatReader in(image);
    return in.value(known_) && in.at_end();
  }
  void tell(TileId to, std::uint64_t number, bool pass_on) {
    FlatWriter out;
    out.value(number);
    out.value(static_cast<std::uint8_t>(pass_on));
    messages_.emplace_back(to, out.take());
  }
  void tell_again(TileId to) {
    tell(to, stage_.number(self_), true);
    if (known_.passed_on > 0) tell(to, known_.passed_on, false);
  }

  TileId self_;
  const GreatestStage& stage_;
  std::vector<TileId> neighbours_;
  Known known_;
  std::vector<std::pair<std::uint64_t, std::uint8_t>> taken_;
  std::vector<std::pair<TileId, Message>> messages_;
  ExchangeCounts counts_;
};

inline std::unique_ptr<TileProgram> GreatestStage::program_of(TileId tile) const {
  return std::make_unique<Greatest>(tile, *this);
}

}  // namespace tessera::testing
