#include "src/run/tile_state.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <iterator>
#include <string>
#include <utility>

#include "src/base/check.h"
#include "src/kernel/brio.h"
#include "src/run/duplicates.h"
#include "src/tiling/hilbert.h"

namespace tessera {

TileState::TileState(Peer self, const TileContext& context)
    : self_(self), context_(context), table_(context.table), mail_(self.tile, context.mail_points_max) {}

Error TileState::damaged(const char* what) const {
  return error(Errc::corrupt, "tile " + std::to_string(self_.tile.value) + ": its " + what + " on disk is damaged");
}

template <class Work>
auto TileState::with_what_was_read(const Work& work) -> decltype(work()) {
  std::string reason;
  try {
    return work();
  } catch (const Unsound& e) {
    reason = e.what();
  }
  const std::string name = "tile " + std::to_string(self_.tile.value) + ": ";
  if (!read_back_) return error(Errc::internal, name + reason);
  BOOST_OUTCOME_TRYV(remove_beginnings(*context_.storage, self_.tile));
  return error(Errc::corrupt, name + "what it has left on disk is no triangulation: " + reason);
}

Status TileState::begin() {
  check(phase_ == Phase::fresh, "a tile begins once");
  return with_what_was_read([&] { return begin_somehow(); });
}

Status TileState::begin_somehow() {
  BOOST_OUTCOME_TRY(restored, restore(false));
  if (!restored) {
    BOOST_OUTCOME_TRY(taken, restore_handed());
    if (!taken) {
      BOOST_OUTCOME_TRYV(build(true));
    }
  }
  counts_ = triangulation_->counts();
  phase_ = Phase::awake;
  // What it has heard by then, the seeds and what its neighbours announce, it processes together.
  call_ = triangulation_->due();
  return success();
}

Status TileState::build(bool announce) {
  finals_.reset();  // of an image that was none
  stored_early_ = {};
  finals_sum_ = 0;
  read_back_ = false;
  BOOST_OUTCOME_TRY(loaded, context_.storage->load_points(self_.tile));
  own_points_ = loaded.points.size();
  if (!loaded.duplicates.empty()) {
    BOOST_OUTCOME_TRYV(context_.storage->write(self_.tile, ScratchKind::duplicates, duplicates_to_bytes(loaded)));
    std::vector<std::pair<PointId, PointId>>().swap(loaded.duplicates);
  }
  const Box& box = (*context_.boxes)[self_.tile.value];
  triangulation_ = std::make_unique<TileTriangulation>(options());
  // Kept until collect() when the tile is not reduced; moving the vector leaves its points where they are.
  triangulation_->triangulate(loaded.points, loaded.ids, KeepPoints::borrowed);
  // A tile that is collected at once is not worth reducing, but for what it stores.
  if (early() || (context_.reduce && announce)) {
    FinalCells finals = triangulation_->reduce(loaded.points, box, !context_.reduce || !announce);
    if (triangulation_->handed_out()) {
      BOOST_OUTCOME_TRYV(keep_finals(std::move(finals), loaded, !announce));
    }
  }
  if (announce && box.lo.x < box.hi.x) triangulation_->announce(loaded.points, box);
  if (!triangulation_->reduced() || !announce) points_ = std::make_unique<LoadedTile>(std::move(loaded));
  return success();
}

Status TileState::receive(Update update) {
  if (dead(update) || handed_) return success();
  if (phase_ == Phase::gone) {
    return error(Errc::internal, "tile " + std::to_string(self_.tile.value) + " got mail after quiescence");
  }
  waiting_hops_ = std::max(waiting_hops_, update.hops);
  return mail_.add(std::move(update), *context_.storage);
}

void TileState::rejoin(std::shared_ptr<const Table> table, const Rebirths* rebirths) {
  if (table->epoch <= table_->epoch || phase_ == Phase::gone) return;
  if (phase_ != Phase::fresh) {
    std::uint64_t reached = table->epoch;
    for (const Rebirths* r = rebirths; r && r->epoch > table_->epoch; r = r->before.get()) {
      check(r->epoch == reached, "tables follow one another");
      reached = r->after;
      std::copy_if(r->tiles.begin(), r->tiles.end(), std::back_inserter(reborn_),
                   [&](TileId t) { return t != self_.tile; });
    }
    check(reached <= table_->epoch, "a tile hears of all tables since its own");
    call_ |= !reborn_.empty();
  }
  table_ = std::move(table);
  counters_.forget_if([&](Peer peer) { return table_->dead(peer); });
  if (context_.watch) context_.watch->rejoined(self_, counters_.totals());
}

Status TileState::splay() {
  return with_what_was_read([&] { return process_mail(); });
}

Status TileState::process_mail() {
  if (storing_.valid() && storing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    BOOST_OUTCOME_TRYV(await_stored());  // a full disk need not be found at the end
  }
  BOOST_OUTCOME_TRYV(wake());
  BOOST_OUTCOME_TRY(mail, mail_.take(*context_.storage));
  std::erase_if(mail, [&](const Update& update) { return dead(update); });
  for (Update& update : mail) {
    if (update.epoch == table_->epoch) continue;
    for (SharedPoint& p : update.points) p.told = 0;
  }
  hops_ = std::max(hops_, std::exchange(waiting_hops_, 0));
  if (!reborn_.empty()) {
    std::sort(reborn_.begin(), reborn_.end());
    reborn_.erase(std::unique(reborn_.begin(), reborn_.end()), reborn_.end());
    triangulation_->replay_to(std::exchange(reborn_, {}));
  }
  BOOST_OUTCOME_TRYV(insert(mail));
  triangulation_->introduce();
  imaged_ = false;
  for (const Update& update : mail) {
    counters_.add_processed(update.from);
    if (context_.watch) context_.watch->processed(update.from, self_, counters_.totals());
  }
  counts_ = triangulation_->counts();
  return success();
}

// In Hilbert order, so that each insertion starts where the last one ended, but a random few first: the first points
// beyond the hull see a whole face of it, and in Hilbert order alone every point would be the first of its region. Few,
// for they are far from each other, and each finds its cells out of the cache.
Status TileState::insert(const std::vector<Update>& mail) {
  struct Item {
    std::uint64_t key;
    TileId from;
    const SharedPoint* point;
  };
  Bounds bounds;
  std::size_t n = 0;
  for (const Update& update : mail) {
    n += update.points.size();
    for (const SharedPoint& p : update.points) bounds.add(p.at);
  }
  const HilbertKey key(bounds, context_.dimension);
  std::vector<Item> items;
  items.reserve(n);
  for (const Update& update : mail) {
    for (const SharedPoint& p : update.points) items.push_back({key(p.at), update.from.tile, &p});
  }
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.key < b.key; });
  Status done = success();
  for_each_in_brio_order<5>(n, [&](std::size_t i) {
    if (done) done = triangulation_->receive(items[i].from, std::span(items[i].point, 1));
  });
  return done;
}

std::vector<Update> TileState::take_outgoing() {
  std::vector<Update> out;
  if (std::exchange(call_, false)) out.push_back(outgoing(self_, {}));
  if (!triangulation_) return out;
  for (auto& [tile, points] : triangulation_->take_updates()) {
    const std::size_t n = points.size();
    for (std::size_t begin = 0; begin < n; begin += update_points_max) {
      const std::size_t end = std::min(n, begin + update_points_max);
      const auto first = points.begin() + static_cast<std::ptrdiff_t>(begin);
      out.push_back(outgoing(table_->peer_of(tile),
                             end - begin == n ? std::move(points)
                                              : std::vector(first, points.begin() + static_cast<std::ptrdiff_t>(end))));
    }
  }
  return out;
}

Update TileState::outgoing(Peer to, std::vector<SharedPoint> points) {
  counters_.add_sent(to);
  ++updates_sent_;
  if (context_.watch) context_.watch->sent(self_, to, counters_.totals());
  return {self_, to, table_->epoch, hops_ + 1, std::move(points)};
}

// The star of a point among the tile's own points and their neighbours is its star among all points, and more points
// change nothing: all foreign vertices are written, which include the neighbours.
Status TileState::settle() {
  if (context_.many_nodes) {
    BOOST_OUTCOME_TRYV(wake());
  } else {
    if (phase_ != Phase::awake || imaged_) return success();
    // An image from before tells less. Were what is written now lost, whoever looks for it would take that for all.
    BOOST_OUTCOME_TRYV(context_.storage->remove(self_.tile, ScratchKind::state));
  }
  const std::vector<SharedPoint> foreign = triangulation_->foreign_vertices();
  return context_.storage->write(self_.tile, ScratchKind::settled, std::as_bytes(std::span(foreign)));
}

Status TileState::build_settled() {
  BOOST_OUTCOME_TRY(pieces, context_.storage->read(self_.tile, ScratchKind::settled));
  if (pieces.empty() && context_.many_nodes) return damaged("list of foreign vertices");
  if (pieces.empty()) {  // it slept when all was quiet
    BOOST_OUTCOME_TRY(restored, restore(true));
    if (!restored) return damaged("image");
  } else {
    if (pieces.size() != 1 || pieces[0].size() % sizeof(SharedPoint) != 0) return damaged("foreign vertices");
    Update update;
    update.from = self_;
    update.points.resize(pieces[0].size() / sizeof(SharedPoint));
    if (!update.points.empty()) std::memcpy(update.points.data(), pieces[0].data(), pieces[0].size());
    pieces = {};
    BOOST_OUTCOME_TRYV(build(false));
    BOOST_OUTCOME_TRYV(insert({std::move(update)}));
  }
  triangulation_->take_updates();  // everybody knows
  phase_ = Phase::awake;
  return success();
}

Result<CollectedTile> TileState::collect() {
  return with_what_was_read([&] { return collect_all(); });
}

Result<CollectedTile> TileState::collect_all() {
  if (phase_ == Phase::fresh) {
    BOOST_OUTCOME_TRYV(build_settled());
  }
  BOOST_OUTCOME_TRYV(wake());
  if (!points_) {
    BOOST_OUTCOME_TRY(loaded, context_.storage->load_points(self_.tile));
    points_ = std::make_unique<LoadedTile>(std::move(loaded));
    if (points_->points.size() != own_points_) return damaged("file of points");
  }
  KeptFinals finals;
  if (triangulation_->handed_out()) {
    auto taken = take_finals();
    if (!taken && taken.error().code == Errc::corrupt) {  // nothing begins from its image again, which needs them
      BOOST_OUTCOME_TRYV(context_.storage->remove(self_.tile, ScratchKind::state));
    }
    if (!taken) return taken.error();
    finals = std::move(taken).value();
  }
  CollectedTile tile = triangulation_->collect(std::move(points_->points), std::move(points_->ids), std::move(finals));
  BOOST_OUTCOME_TRYV(await_stored());
  tile.stored = std::move(stored_early_);
  counts_ = triangulation_->counts();
  drop();
  return tile;
}

Status TileState::leave() {
  check(phase_ == Phase::fresh, "only a tile that has not begun leaves");
  phase_ = Phase::gone;
  return mail_.clear(*context_.storage);
}

void TileState::drop() {
  triangulation_.reset();
  points_.reset();
  finals_.reset();
  phase_ = Phase::gone;
}

std::size_t TileState::memory() const {
  return (triangulation_ ? triangulation_->memory() : 0) + (points_ ? points_->points.size() * 32 : 0) +
         (finals_ ? finals_->bytes() : 0) + mail_.memory() + counters_.memory();
}

}  // namespace tessera
