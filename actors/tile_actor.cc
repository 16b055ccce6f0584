#include "actors/tile_actor.h"

#include <malloc.h>

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "actors/worker_clock.h"

namespace tessera {
namespace {

constexpr int entry_fields = 7;

Phase phase_of(Work work) {
  switch (work) {
    case Work::triangulate:
      return Phase::triangulating;
    case Work::collect:
      return Phase::collecting;
    case Work::splay:
    case Work::sleep:
      break;
  }
  return Phase::splaying;
}

}  // namespace

std::vector<std::uint64_t> to_numbers(const TileEntry& e) {
  return {e.tile, e.points, e.own_points, e.cells, e.main_cells, e.bytes, e.xxh3};
}

TileEntry entry_from_numbers(const std::vector<std::uint64_t>& n) {
  if (n.size() != entry_fields) return {};
  return {static_cast<std::uint32_t>(n[0]), n[1], n[2], n[3], n[4], n[5], n[6]};
}

TileActor::TileActor(caf::actor_config& config, Peer self, const TileContext& context, const Directory& directory)
    : caf::event_based_actor(config), self_(self), directory_(directory), context_(context), state_(self, context) {}

caf::behavior TileActor::make_behavior() {
  // An error that comes back from a peer must not end the tile: the node decides what to do about lost peers.
  set_error_handler([](caf::scheduled_actor*, caf::error&) {});
  return {
      [this](Batch& batch) {
        directory_.tell([&] { return "tile " + std::to_string(self_.tile.value) + ": receives " + to_string(batch); });
        state_.receive(std::move(batch));
        if (!std::exchange(told_node_, true)) {
          send(directory_.node, MailNotice{self_.tile.value, state_.waiting_points()});
        }
      },
      [this](const Grant& grant) { work(grant.work); },
  };
}

void TileActor::work(Work work) {
  TileReport report = perform(work);
  for (Batch& batch : state_.take_outgoing()) {
    const TileId to = batch.to.tile;
    directory_.tell([&] { return "tile " + std::to_string(self_.tile.value) + ": posts " + to_string(batch); });
    send(directory_.route_to(to), std::move(batch));
  }
  // After take_outgoing(): what is on its way counts as sent before the node can ask.
  const Totals totals = state_.totals();
  report.sent = totals.sent;
  report.processed = totals.processed;
  report.memory = state_.memory() + (mesh_ ? mesh_->bytes() : 0);
  report.waiting = state_.waiting_points();
  report.hops = state_.hops();
  const ExchangeCounts& counts = state_.counts();
  report.received = counts.received;
  report.inserted = counts.inserted;
  report.kept = counts.kept;
  report.points_sent = counts.sent;
  told_node_ = report.waiting > 0;
  send(directory_.node, std::move(report));
  if (mesh_) store();
}

void TileActor::store() {
  const auto tell = [node = directory_.node, tile = self_.tile.value](const Result<TileEntry>& stored) {
    if (stored) {
      caf::anon_send(node, TileStored{tile, 0, "", to_numbers(stored.value())});
    } else {
      caf::anon_send(node, TileStored{tile, static_cast<std::uint8_t>(stored.error().code), stored.error().where, {}});
    }
  };
  context_.storage->store(self_.tile, *std::exchange(mesh_, std::nullopt), tell);
}

TileReport TileActor::perform(Work work) {
  TileReport report;
  report.tile = self_.tile.value;
  report.work = work;
  const auto fail = [&](const Error& e) {
    report.failed = static_cast<std::uint8_t>(e.code);
    report.failure = e.where;
  };
  const WorkSpan span(context_.progress, phase_of(work), self_.tile);
  try {
    if (work == Work::collect) {
      auto mesh = state_.collect();
      if (mesh) {
        mesh_ = std::move(mesh.value());
      } else {
        fail(mesh.error());
      }
    } else {
      const Status done = work == Work::triangulate ? state_.triangulate()
                          : work == Work::splay     ? state_.splay()
                                                    : state_.sleep();
      if (!done) fail(done.error());
    }
  } catch (const KernelFull&) {
    fail(error(Errc::memory, "tile " + std::to_string(self_.tile.value) +
                                 " has more points than a kernel can number: use smaller tiles"));
  } catch (const std::bad_alloc&) {
    fail(error(Errc::memory, "out of memory while working on tile " + std::to_string(self_.tile.value) +
                                 ": use smaller tiles or a smaller --memory"));
  } catch (const std::exception& e) {  // an actor that ends by an exception says nothing, and the run would wait for it
    fail(error(Errc::internal, "tile " + std::to_string(self_.tile.value) + ", " + name_of(work) + ": " + e.what()));
  }
  if (work == Work::triangulate) {
    report.own_points = state_.own_points();
    for (const auto& [duplicate, kept] : state_.take_duplicates()) {
      report.duplicates.push_back(duplicate);
      report.duplicates.push_back(kept);
    }
  }
  if (context_.reduce) malloc_trim(0);  // what the work has left behind in pools, where nobody else finds it
  report.microseconds = span.microseconds();
  return report;
}

}  // namespace tessera
