#include "actors/tile_actor.h"

#include <malloc.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <utility>

#include "actors/failing.h"

namespace tessera {
namespace {

// More mail than this is told of again, so that the part knows what its tiles hold.
constexpr std::uint64_t notice_bytes = 64 << 10;

// Threads in the order in which they first did any work.
std::uint32_t thread_number() {
  static std::atomic<std::uint32_t> next{0};
  thread_local const std::uint32_t number = next++;
  return number;
}

std::string name_of(TileId tile) { return "tile " + std::to_string(tile.value); }

// From a writer's thread, where nobody catches: an exception here would be the end of the process, silence that of the
// job. What was set aside when the mesh was handed over pays for the one message that must not fail.
class StoredNotice {
 public:
  StoredNotice(PartHandle part, TileId tile)
      : part_(std::move(part)),
        tile_(tile),
        reserve_(std::make_shared<std::vector<std::byte>>(std::size_t{64} << 10)) {}
  void operator()(const Result<TileEntry>& stored) const noexcept {
    try {
      caf::anon_send(
          part_, stored ? TileStored{tile_, {}, stored.value()} : TileStored{tile_, failure_of(stored.error()), {}});
    } catch (const std::exception&) {
      *reserve_ = {};
      caf::anon_send(part_, TileStored{tile_, {static_cast<std::uint8_t>(Errc::memory), "out of memory"}, {}});
    }
  }

 private:
  PartHandle part_;
  TileId tile_;
  std::shared_ptr<std::vector<std::byte>> reserve_;
};

}  // namespace

TileActor::TileActor(caf::actor_config& config, Peer self, std::shared_ptr<const Part> part,
                     std::shared_ptr<const Office> office)
    : TileHandle::base(config),
      self_(self),
      part_(std::move(part)),
      office_(std::move(office)),
      state_(self, part_->context) {}

// Tiles and their office know each other: one that has ended must not keep the others alive.
void TileActor::on_exit() {
  state_.drop();
  mesh_.reset();
  office_ = nullptr;
  part_ = nullptr;
}

TileActor::behavior_type TileActor::make_behavior() {
  // Nobody answers a tile; an error that comes back all the same means that a message did not arrive.
  set_error_handler([this](caf::scheduled_actor*, caf::error& reason) {
    send(office_->part, TileFailed{self_.tile, lost("a message of " + name_of(self_.tile), reason)});
  });
  set_exception_handler([this](std::exception_ptr& exception) -> caf::error {
    send(office_->part, TileFailed{self_.tile, failure_of(exception, name_of(self_.tile))});
    return caf::sec::runtime_error;
  });
  return {
      [this](Batch& batch) {
        office_->hooks.tell([&] { return name_of(self_.tile) + ": receives " + to_string(batch); });
        if (const Status kept = state_.receive(std::move(batch)); !kept) {
          send(office_->part, TileFailed{self_.tile, failure_of(kept.error())});
          return;
        }
        const std::uint64_t bytes = state_.mail_memory();
        if (std::exchange(told_, true) && bytes < bytes_told_ + notice_bytes) return;
        bytes_told_ = bytes;
        send(office_->part, waiting());
      },
      [this](const Grant& grant) { work(grant.work); },
  };
}

MailNotice TileActor::waiting() const {
  return {self_.tile, state_.waiting_batches(), state_.waiting_points(), state_.mail_memory()};
}

void TileActor::work(Work work) {
  const auto since_opened = [&] {
    const auto elapsed = std::chrono::steady_clock::now() - office_->opened;
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(elapsed).count());
  };
  TileReport report;
  report.span = {self_.tile, work, thread_number(), since_opened(), 0};
  try {
    if (const Status done = perform(work); !done) report.failure = failure_of(done.error());
    for (Batch& batch : state_.take_outgoing()) {
      office_->hooks.tell([&] { return name_of(self_.tile) + ": posts " + to_string(batch); });
      office_->post(this, std::move(batch));
    }
  } catch (...) {  // an actor that ends by an exception says little, and its grant would stay out
    report.failure = failure_of(std::current_exception(), name_of(self_.tile) + ", at work on " + name_of(work));
  }
  if (part_->context.reduce) malloc_trim(0);  // what the work has left behind in pools, where nobody else finds it
  report.span.end_us = since_opened();
  // After the batches were posted: what is on its way counts as sent before the part can ask.
  const Totals totals = state_.totals();
  report.sent = totals.sent;
  report.processed = totals.processed;
  report.batches = state_.batches_sent();
  report.memory = state_.memory() - state_.mail_memory();
  report.storing = mesh_ ? mesh_->bytes() : 0;
  report.waiting = waiting();
  report.hops = state_.hops();
  report.points = state_.counts();
  told_ = report.waiting.batches > 0;
  bytes_told_ = report.waiting.bytes;
  send(office_->part, std::move(report));
  if (mesh_) store();
}

void TileActor::store() {
  part_->context.storage->store(self_.tile, *std::exchange(mesh_, std::nullopt),
                                StoredNotice(office_->part, self_.tile));
}

Status TileActor::perform(Work work) {
  switch (work) {
    case Work::begin:
      return state_.begin();
    case Work::splay:
      return state_.splay();
    case Work::sleep:
      return state_.sleep();
    case Work::settle:
      return state_.settle();
    case Work::collect: {
      BOOST_OUTCOME_TRY(mesh, state_.collect());
      mesh_ = std::move(mesh);
      return success();
    }
    case Work::drop:
      state_.drop();
      return success();
  }
  return success();
}

}  // namespace tessera
