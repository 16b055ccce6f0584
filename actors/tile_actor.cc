#include "actors/tile_actor.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <utility>

#include "actors/failing.h"

namespace tessera {
namespace {

// The share is told again when waiting mail has grown by so much, so that it knows what its tiles hold.
constexpr std::uint64_t notice_bytes = 64 << 10;

// Numbers threads in the order in which they first did any work.
std::uint32_t thread_number() {
  static std::atomic<std::uint32_t> next{0};
  thread_local const std::uint32_t number = next++;
  return number;
}

std::string name_of(TileId tile) { return "tile " + std::to_string(tile.value); }

// The function that a writer's thread calls when a tile is stored. No code catches exceptions there, so an exception
// would end the process. If it said nothing, the job would never end. So the message is made before the tile is handed
// over.
class StoredNotice {
 public:
  StoredNotice(ShareHandle share, TileId tile)
      : share_(std::move(share)), prepared_(std::make_shared<Prepared<TileStored>>()) {
    prepared_->message().tile = tile;
  }
  void operator()(Result<Receipt> stored) const noexcept {
    TileStored& message = prepared_->message();
    if (stored) {
      message.receipt = std::move(stored).value();
    } else {
      message.failure = failure_of(std::move(stored).error());
    }
    prepared_->say(share_);
  }

 private:
  ShareHandle share_;
  std::shared_ptr<Prepared<TileStored>> prepared_;  // shared, because a std::function is copied
};

}  // namespace

TileActor::TileActor(caf::actor_config& config, TileIncarnation self, std::shared_ptr<const Share> share,
                     std::shared_ptr<const ActorDirectory> directory, const std::shared_ptr<const RoutingTable>& table)
    : SteadyActor(config),
      self_(self),
      share_(std::move(share)),
      directory_(std::move(directory)),
      life_(self, share_->stages.at(table->stage).context, table) {
  live_at(directory_->hooks.home);
  last_message_.message().tile = self.tile;
}

// Tile and directory refer to each other. A tile that has ended must not keep the others alive.
void TileActor::on_exit() {
  if (!left_) fail(ended_unexpectedly());
  life_.drop();
  finished_.reset();
  directory_ = nullptr;
  share_ = nullptr;
}

void TileActor::failed(const std::exception_ptr& exception) noexcept {
  fail(failure_of(exception, [&] { return name_of(self_.tile); }));
}

void TileActor::fail(Failure failure) noexcept {
  if (!std::exchange(left_, true)) {
    last_message_.message().failure = std::move(failure);
    last_message_.say(directory_->share);
  }
  quit();
}

TileActor::behavior_type TileActor::make_behavior() {
  // No actor answers a tile. An error that comes back means that a message did not arrive.
  set_error_handler(
      [this](caf::scheduled_actor*, caf::error& reason) { fail(lost("a message of " + name_of(self_.tile), reason)); });
  return {
      [this](Delivery& delivery) {
        Update& update = delivery.update;
        directory_->hooks.tell([&] { return name_of(self_.tile) + ": receives " + to_string(update); });
        const std::uint64_t weight = Outbox::bytes_of(update);
        if (Status kept = life_.receive(std::move(update)); !kept) return fail(failure_of(std::move(kept).error()));
        if (delivery.from != directory_->self) send(directory_->share, Taken{delivery.from, weight});
        const std::uint64_t bytes = life_.mail_memory();
        const std::uint32_t hops = life_.waiting_hops();
        if (std::exchange(told_, true) && bytes < bytes_told_ + notice_bytes && hops == hops_told_) return;
        bytes_told_ = bytes;
        hops_told_ = hops;
        send(directory_->share, waiting());
      },
      [this](const Permit& permit) { work(permit.work); },
      [this](const Rejoin&) { rejoin(); },
      [this](const Leave& leave) {
        if (leave.given_up) {
          if (Status left = life_.leave(); !left) return fail(failure_of(std::move(left).error()));
          send(directory_->share, TileLeft{self_.tile});
        }
        left_ = true;
        quit();
      },
  };
}

MailNotice TileActor::waiting() const {
  return {self_.tile, life_.waiting_updates(), life_.waiting_bytes(), life_.mail_memory(), life_.waiting_hops()};
}

void TileActor::work(Work work) {
  const auto since_opened = [&] {
    const auto elapsed = std::chrono::steady_clock::now() - directory_->opened;
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(elapsed).count());
  };
  TileReport report;
  report.span = {self_.tile, work, thread_number(), since_opened(), 0};
  const std::uint64_t before = life_.memory();
  try {
    if (Status done = perform(work); !done) {
      report.kept = work != Work::hand_over;  // otherwise the tile begins again elsewhere
      if (report.kept) report.failure = failure_of(std::move(done).error());
    }
    post_outgoing();
  } catch (...) {
    // Caught here, because an actor that ends by an exception says little, and its permit would never come back.
    report.failure =
        failure_of(std::current_exception(), [&] { return name_of(self_.tile) + " (work: " + name_of(work) + ")"; });
  }
  share_->heap_trim.worked_on(std::max(before, life_.memory()) + (finished_ ? finished_->bytes() : 0));
  report.span.end_us = since_opened();
  // The updates were posted before, so what is under way counts as sent before the share can ask.
  const Totals totals = life_.totals();
  report.sent = totals.sent;
  report.processed = totals.processed;
  report.updates = life_.updates_sent();
  report.memory = life_.memory() - life_.mail_memory();
  report.storing = finished_ ? finished_->bytes() : 0;
  report.waiting = waiting();
  report.hops = life_.hops();
  report.items = life_.counts();
  told_ = report.waiting.updates > 0;
  bytes_told_ = report.waiting.bytes;
  hops_told_ = report.waiting.hops;
  send(directory_->share, std::move(report));
  if (finished_) store();
}

void TileActor::post_outgoing() {
  for (Update& update : life_.take_outgoing()) {
    directory_->hooks.tell([&] { return name_of(self_.tile) + ": posts " + to_string(update); });
    if (share_->mail) share_->mail->add(update.from.tile, update.to.tile, update.message.size());
    directory_->post(this, std::move(update));
  }
}

// What other tiles must be told again waits for the next step, so a sleeping tile stays asleep until there is room.
void TileActor::rejoin() {
  const auto routes = directory_->routes();
  life_.rejoin(routes->table, routes->rebirths.get());
  post_outgoing();
  const Totals totals = life_.totals();
  send(directory_->share, TileRejoined{self_.tile, routes->table->epoch, totals.sent, totals.processed, waiting()});
}

void TileActor::store() { std::exchange(finished_, nullptr)->store(StoredNotice(directory_->share, self_.tile)); }

Status TileActor::perform(Work work) {
  switch (work) {
    case Work::begin:
      return life_.begin();
    case Work::step:
      return life_.step();
    case Work::sleep:
      return life_.sleep();
    case Work::settle:
      return life_.settle();
    case Work::finish: {
      BOOST_OUTCOME_TRY(finished, life_.finish());
      finished_ = std::move(finished);
      return success();
    }
    case Work::drop:
      life_.drop();
      return success();
    case Work::hand_over:
      return life_.hand_over();
  }
  return success();
}

}  // namespace tessera
