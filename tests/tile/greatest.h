// A program that is no triangulation: each tile learns the greatest number among its own, its neighbours' and theirs.
// What the machine does for one program it does for any.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "src/base/flat_codec.h"
#include "src/run/tile_program.h"

namespace tessera::testing {

struct GreatestStage final : TilePrograms {
  std::unique_ptr<TileProgram> program_of(TileId tile) const override;
  std::vector<std::vector<TileId>> neighbours;  // by tile
  std::vector<std::uint64_t> numbers;           // by tile
};

struct GreatestFound final : Finished {
  explicit GreatestFound(std::uint64_t n) : number(n) {}
  std::uint64_t bytes() const override { return sizeof number; }
  void store(TileStorage&, TileId tile, TileStorage::Stored done) override {
    TileEntry entry;
    entry.tile = tile;
    done(std::move(entry));
  }
  std::uint64_t number;
};

// A message is a number, and whether it is to be passed on.
class Greatest final : public TileProgram {
 public:
  Greatest(TileId self, const GreatestStage& stage) : self_(self), stage_(stage) {}

  Status begin() override {
    known_ = {stage_.numbers.at(self_.value), 0};
    for (const TileId to : stage_.neighbours.at(self_.value)) tell(to, known_.greatest, true);
    return success();
  }
  Status begin_settled(Message settled) override {
    return read(settled) ? Status(success()) : damaged(self_, "number");
  }
  Status take(TileId, bool, Message message) override {
    std::uint64_t number = 0;
    bool pass_on = false;
    if (message.empty()) return success();  // the tile's call to itself
    FlatReader in(message);
    if (!in.value(number) || !in.value(pass_on)) return error(Errc::internal, "no number");
    taken_.emplace_back(number, pass_on);
    return success();
  }
  Status step() override {
    for (const auto& [number, pass_on] : std::exchange(taken_, {})) {
      known_.greatest = std::max(known_.greatest, number);
      if (!pass_on || number <= known_.passed_on) continue;
      known_.passed_on = number;
      for (const TileId to : stage_.neighbours.at(self_.value)) tell(to, number, false);
    }
    return success();
  }
  bool due() const override { return false; }
  std::vector<std::pair<TileId, Message>> messages() override { return std::exchange(messages_, {}); }
  void replay_to(std::span<const TileId> reborn) override {
    for (const TileId to : stage_.neighbours.at(self_.value))
      if (std::binary_search(reborn.begin(), reborn.end(), to)) tell_again(to);
  }

  Status put_aside() override { return success(); }
  Image save() override { return settled(); }
  Result<bool> load(Image image, ImageOf whose) override {
    if (!read(image)) return false;
    if (whose != ImageOf::sleeper)
      for (const TileId to : stage_.neighbours.at(self_.value)) tell_again(to);
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
    return std::unique_ptr<Finished>(std::make_unique<GreatestFound>(known_.greatest));
  }
  std::size_t memory() const override { return sizeof *this; }
  const ExchangeCounts& counts() const override { return counts_; }

 private:
  struct Known {
    std::uint64_t greatest = 0, passed_on = 0;
  };
  bool read(const Image& image) {
    FlatReader in(image);
    return in.value(known_) && in.at_end();
  }
  void tell(TileId to, std::uint64_t number, bool pass_on) {
    FlatWriter out;
    out.value(number);
    out.value(pass_on);
    messages_.emplace_back(to, out.take());
  }
  void tell_again(TileId to) {
    tell(to, stage_.numbers.at(self_.value), true);
    if (known_.passed_on > 0) tell(to, known_.passed_on, false);
  }

  TileId self_;
  const GreatestStage& stage_;
  Known known_;
  std::vector<std::pair<std::uint64_t, bool>> taken_;
  std::vector<std::pair<TileId, Message>> messages_;
  ExchangeCounts counts_;
};

inline std::unique_ptr<TileProgram> GreatestStage::program_of(TileId tile) const {
  return std::make_unique<Greatest>(tile, *this);
}

}  // namespace tessera::testing
