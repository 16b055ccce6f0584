#include "src/exchange/tile_life.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "src/base/check.h"

namespace tessera {

TileLife::TileLife(TileIncarnation self, const TileContext& context, std::shared_ptr<const RoutingTable> table)
    : self_(self),
      context_(context),
      table_(std::move(table)),
      program_(context.programs->program_of(self.tile)),
      inbox_(self.tile, context.mail_bytes_max) {}

template <class Work>
auto TileLife::with_what_was_read(const Work& work) -> decltype(work()) {
  std::string reason;
  try {
    return work();
  } catch (const Unsound& e) {
    reason = e.what();
  }
  const std::string name = "tile " + std::to_string(self_.tile.value) + ": ";
  if (!read_back_) return error(Errc::internal, name + reason);
  BOOST_OUTCOME_TRYV(remove_beginnings(*context_.storage, self_.tile));
  return error(Errc::corrupt, name + "its files on disk do not fit, so the tile cannot continue from them: " + reason);
}

Status TileLife::begin() {
  check(state_ == State::fresh, "a tile begins once");
  return with_what_was_read([&] { return begin_somehow(); });
}

Status TileLife::begin_somehow() {
  BOOST_OUTCOME_TRY(restored, restore(ImageOf::earlier));
  if (!restored) {
    BOOST_OUTCOME_TRY(taken, restore_handed());
    if (!taken) {
      read_back_ = false;
      BOOST_OUTCOME_TRYV(program_->begin());
    }
  }
  state_ = State::awake;
  // Asks for a step. What the tile has heard by then, and what its neighbours tell it first, is processed in it
  // together.
  call_ = program_->due();
  return success();
}

// Returns false when there is no image, or no sound one.
Result<bool> TileLife::restore(ImageOf whose) {
  auto pieces = context_.storage->read(self_.tile, ScratchKind::state);
  if (!pieces || pieces.value().size() != 1) return false;
  read_back_ = true;
  BOOST_OUTCOME_TRY(loaded, program_->load(std::move(pieces.value()[0]), whose));
  imaged_ = loaded;
  return loaded;
}

// Which incarnation left the image, and how old it is, does not matter: an image is a right beginning whatever the
// other tiles have done since. If it cannot be read, what the stage before has left is a right beginning, too.
Result<bool> TileLife::restore_handed() {
  auto pieces = context_.storage->handed(self_.tile);
  if (!pieces || pieces.value().size() != 1) return false;
  read_back_ = true;
  return program_->load_packed(std::move(pieces.value()[0]));
}

Status TileLife::receive(Update update) {
  if (dead(update) || handed_) return success();
  if (state_ == State::gone) {
    return error(Errc::internal, "tile " + std::to_string(self_.tile.value) + " got mail after quiescence");
  }
  waiting_hops_ = std::max(waiting_hops_, update.hops);
  return inbox_.add(std::move(update), *context_.storage);
}

void TileLife::rejoin(std::shared_ptr<const RoutingTable> table, const IncarnationChanges* rebirths) {
  if (table->epoch <= table_->epoch || state_ == State::gone) return;
  if (state_ != State::fresh) {
    Epoch reached = table->epoch;
    for (const IncarnationChanges* r = rebirths; r && r->epoch > table_->epoch; r = r->before.get()) {
      check(r->epoch == reached, "tables follow one another");
      reached = r->after;
      std::copy_if(r->tiles.begin(), r->tiles.end(), std::back_inserter(reborn_),
                   [&](TileId t) { return t != self_.tile; });
    }
    check(reached <= table_->epoch, "a tile hears of all tables since its own");
    call_ |= !reborn_.empty();
  }
  table_ = std::move(table);
  counters_.forget_if([&](TileIncarnation peer) { return table_->dead(peer); });
  if (context_.watch) context_.watch->rejoined(self_, counters_.totals());
}

Status TileLife::step() {
  return with_what_was_read([&] { return process_mail(); });
}

Status TileLife::process_mail() {
  BOOST_OUTCOME_TRYV(wake());
  BOOST_OUTCOME_TRY(mail, inbox_.take(*context_.storage));
  std::erase_if(mail, [&](const Update& update) { return dead(update); });
  hops_ = std::max(hops_, std::exchange(waiting_hops_, 0));
  if (!reborn_.empty()) {
    std::sort(reborn_.begin(), reborn_.end());
    reborn_.erase(std::unique(reborn_.begin(), reborn_.end()), reborn_.end());
    program_->replay_to(std::exchange(reborn_, {}));
  }
  for (Update& update : mail) {
    BOOST_OUTCOME_TRYV(program_->take(update.from.tile, update.epoch == table_->epoch, std::move(update.message)));
  }
  BOOST_OUTCOME_TRYV(program_->step());
  imaged_ = false;
  for (const Update& update : mail) {
    counters_.add_processed(update.from);
    if (context_.watch) context_.watch->processed(update.from, self_, counters_.totals());
  }
  return success();
}

std::vector<Update> TileLife::take_outgoing() {
  std::vector<Update> out;
  if (std::exchange(call_, false)) out.push_back(outgoing(self_, {}));
  for (auto& [tile, message] : program_->messages()) {
    out.push_back(outgoing(table_->peer_of(tile), std::move(message)));
  }
  return out;
}

Update TileLife::outgoing(TileIncarnation to, Message message) {
  counters_.add_sent(to);
  ++updates_sent_;
  if (context_.watch) context_.watch->sent(self_, to, counters_.totals());
  return {self_, to, table_->epoch, hops_ + 1, std::move(message)};
}

Status TileLife::sleep() {
  check(state_ == State::awake, "only a tile that is awake falls asleep");
  BOOST_OUTCOME_TRYV(program_->put_aside());
  if (!imaged_) {
    BOOST_OUTCOME_TRYV(context_.storage->write(self_.tile, ScratchKind::state, program_->save()));
    imaged_ = true;
  }
  program_->free();
  counters_.trim();  // many tiles are asleep
  state_ = State::asleep;
  return success();
}

Status TileLife::wake() {
  if (state_ == State::awake) return success();
  check(state_ == State::asleep, "only a tile that sleeps is woken");
  BOOST_OUTCOME_TRY(pieces, context_.storage->read(self_.tile, ScratchKind::state));
  if (pieces.size() != 1) return damaged(self_.tile, "image");
  read_back_ = true;
  BOOST_OUTCOME_TRY(loaded, program_->load(std::move(pieces[0]), ImageOf::sleeper));
  if (!loaded) return damaged(self_.tile, "image");
  state_ = State::awake;
  return success();
}

// docs/cluster-design.md, "Draining".
Status TileLife::hand_over() {
  check(state_ == State::awake || state_ == State::asleep, "only a tile that has begun is handed over");
  const Status written = write_handed();
  drop();
  handed_ = true;
  call_ = false;
  BOOST_OUTCOME_TRYV(inbox_.clear(*context_.storage));
  return written;
}

Status TileLife::write_handed() {
  Image image;
  if (state_ == State::asleep) {
    BOOST_OUTCOME_TRY(pieces, context_.storage->read(self_.tile, ScratchKind::state));
    if (pieces.size() != 1) return damaged(self_.tile, "image");
    image = std::move(pieces[0]);
  } else {
    BOOST_OUTCOME_TRYV(program_->put_aside());
    image = program_->save();
  }
  BOOST_OUTCOME_TRY(packed, program_->pack(std::move(image)));
  return context_.storage->hand_over(self_.tile, packed);
}

Status TileLife::settle() {
  if (context_.many_nodes) {
    BOOST_OUTCOME_TRYV(wake());
  } else {
    if (state_ != State::awake || imaged_) return success();
    // An earlier image says less than what is written now. If that were lost, a reader that finds the image would take
    // it for all.
    BOOST_OUTCOME_TRYV(context_.storage->remove(self_.tile, ScratchKind::state));
  }
  return context_.storage->write(self_.tile, ScratchKind::settled, program_->settled());
}

Status TileLife::begin_settled() {
  BOOST_OUTCOME_TRY(pieces, context_.storage->read(self_.tile, ScratchKind::settled));
  if (pieces.empty() && !context_.many_nodes) {  // the tile was asleep when all was quiet
    BOOST_OUTCOME_TRY(restored, restore(ImageOf::settled));
    if (!restored) return damaged(self_.tile, "image");
  } else {
    if (pieces.size() != 1) return damaged(self_.tile, "settled state");
    read_back_ = false;
    BOOST_OUTCOME_TRYV(program_->begin_settled(std::move(pieces[0])));
  }
  program_->messages();  // all other tiles know them already
  state_ = State::awake;
  return success();
}

Result<std::unique_ptr<Finished>> TileLife::finish() {
  return with_what_was_read([&]() -> Result<std::unique_ptr<Finished>> {
    if (state_ == State::fresh) {
      BOOST_OUTCOME_TRYV(begin_settled());
    }
    BOOST_OUTCOME_TRYV(wake());
    BOOST_OUTCOME_TRY(finished, program_->finish());
    drop();
    return std::move(finished);
  });
}

Status TileLife::leave() {
  check(state_ == State::fresh, "only a tile that has not begun leaves");
  state_ = State::gone;
  return inbox_.clear(*context_.storage);
}

void TileLife::drop() {
  program_->free();
  state_ = State::gone;
}

}  // namespace tessera
