#include "src/delaunay/update/holes_program.h"

#include <algorithm>
#include <iterator>

namespace tessera {
namespace {

class HolesTold final : public Finished {
 public:
  HolesTold(UpdateStore& store, TileId tile, ToldOfHoles told) : store_(store), tile_(tile), told_(std::move(told)) {}
  std::uint64_t bytes() const override { return told_.around.size() * sizeof(SharedPoint); }
  void store(Stored done) override {
    Status kept = told_.empty() ? success() : store_.keep_told(tile_, told_);
    done(kept ? Result<Receipt>(Receipt()) : Result<Receipt>(std::move(kept).error()));
  }

 private:
  UpdateStore& store_;
  TileId tile_;
  ToldOfHoles told_;
};

}  // namespace

// What a tile tells depends on the result and the plan alone, so it is the same in each of its lives.
Status HolesProgram::tell(std::span<const TileId> to) {
  const UpdatePlan& plan = *setting_->plan;
  if (!plan.losing.contains(self_)) return success();
  BOOST_OUTCOME_TRY(mesh, setting_->store->read(self_, true));
  const HolesOfTile holes = holes_of(self_, mesh, plan.removed);
  mesh = {};
  std::vector<SharedPoint> around;
  const std::size_t stride = (holes.around.size() + points_max - 1) / points_max;
  for (std::size_t k = 0; k < holes.around.size(); k += stride) around.push_back(holes.around[k]);
  std::vector<TileId> all;
  const auto touching = setting_->around->neighbours(self_);
  std::set_union(holes.beside.begin(), holes.beside.end(), touching.begin(), touching.end(), std::back_inserter(all));
  for (const TileId tile : all) {
    const bool part = tile != self_ && !setting_->around->bounds(tile).empty();
    if (!part || (!to.empty() && !std::binary_search(to.begin(), to.end(), tile))) continue;
    ToldOfHoles told{std::binary_search(holes.beside.begin(), holes.beside.end(), tile), {}};
    std::copy_if(around.begin(), around.end(), std::back_inserter(told.around),
                 [&](const SharedPoint& p) { return p.tile != tile; });
    counts_.sent += told.around.size();
    messages_.emplace_back(tile, bytes_of(told));
  }
  return success();
}

bool HolesProgram::add(std::span<const std::byte> bytes) {
  const auto told = told_of(bytes);
  if (!told) return false;
  beside_ |= told->beside;
  for (const SharedPoint& p : told->around) around_.emplace(p.id, p);
  return true;
}

ToldOfHoles HolesProgram::told() const {
  ToldOfHoles told{beside_, {}};
  for (const auto& [id, p] : around_) told.around.push_back(p);
  return told;
}

Status HolesProgram::begin_settled(Message settled) {
  return add(settled) ? Status(success()) : damaged(self_, "list of points around holes");
}

Status HolesProgram::take(TileId from, bool, Message message) {
  if (message.empty()) return success();  // the tile's call to itself
  if (add(message)) return success();
  return error(Errc::internal, "tile " + to_string(from) + " has sent no list of points around holes");
}

Status HolesProgram::step() {
  if (reborn_.empty()) return success();
  return tell(std::exchange(reborn_, {}));
}

void HolesProgram::replay_to(std::span<const TileId> reborn) {
  std::vector<TileId> all;
  std::set_union(reborn_.begin(), reborn_.end(), reborn.begin(), reborn.end(), std::back_inserter(all));
  reborn_ = std::move(all);
}

Result<bool> HolesProgram::load(Image image, ImageOf whose) {
  if (!add(image)) return false;
  if (whose == ImageOf::earlier) {
    BOOST_OUTCOME_TRYV(tell({}));
  }
  return true;
}

void HolesProgram::free() {
  around_.clear();
  messages_ = {};
}

Message HolesProgram::settled() const { return bytes_of(told()); }

Result<std::unique_ptr<Finished>> HolesProgram::finish() {
  return std::unique_ptr<Finished>(std::make_unique<HolesTold>(*setting_->store, self_, told()));
}

std::size_t HolesProgram::memory() const {
  std::size_t sum = sizeof *this + around_.size() * (sizeof(SharedPoint) + 48);
  for (const auto& [to, message] : messages_) sum += message.size();
  return sum;
}

}  // namespace tessera
