#include "actors/harness/memory_storage.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <stdexcept>
#include <utility>

namespace tessera {

Status MemoryStorage::maybe_fail(StorageFault::Call call) {
  if (!fault || fault->call != call || fault->countdown-- > 0) return success();
  const auto how = fault->how;
  fault.reset();
  if (how == StorageFault::How::exception) throw std::runtime_error("the harness's storage throws");
  if (how == StorageFault::How::no_memory) throw std::bad_alloc();
  return error(Errc::io, "the harness's storage fails");
}

Result<LoadedTile> MemoryStorage::load_points(TileId tile) {
  const Turn ours(memory_faults, false);
  BOOST_OUTCOME_TRYV(maybe_fail(StorageFault::Call::load));
  ++reads_[{tile, {}}];
  return order_points(points_[tile.value], dimension_);
}

Status MemoryStorage::write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) {
  const Turn ours(memory_faults, false);
  BOOST_OUTCOME_TRYV(maybe_fail(StorageFault::Call::write));
  scratch_[{tile, what}] = {{{bytes.begin(), bytes.end()}}, false};
  return success();
}

Status MemoryStorage::append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) {
  const Turn ours(memory_faults, false);
  BOOST_OUTCOME_TRYV(maybe_fail(StorageFault::Call::append));
  scratch_[{tile, what}].pieces.emplace_back(bytes.begin(), bytes.end());
  ++spills_;
  return success();
}

Result<TileStorage::Pieces> MemoryStorage::read(TileId tile, ScratchKind what) {
  const Turn ours(memory_faults, false);
  BOOST_OUTCOME_TRYV(maybe_fail(StorageFault::Call::read));
  const auto found = scratch_.find({tile, what});
  if (found == scratch_.end()) return Pieces{};
  ++reads_[{tile, what}];
  if (found->second.damaged) return error(Errc::corrupt, "the harness has damaged it");
  return found->second.pieces;
}

Status MemoryStorage::remove(TileId tile, ScratchKind what) {
  const Turn ours(memory_faults, false);
  BOOST_OUTCOME_TRYV(maybe_fail(StorageFault::Call::remove));
  scratch_.erase({tile, what});
  return success();
}

Status MemoryStorage::clear(ScratchKind what) {
  const Turn ours(memory_faults, false);
  std::erase_if(scratch_, [&](const auto& entry) { return entry.first.second == what; });
  return success();
}

void MemoryStorage::store(TileId tile, TileMesh mesh, Stored done) {
  const Turn ours(memory_faults, false);
  Pending pending{tile, std::move(mesh), std::move(done)};
  if (!late_stores) return store_now(std::move(pending));
  pending_.push_back(std::move(pending));
}

void MemoryStorage::store_now(Pending pending) {
  const Turn ours(memory_faults, false);
  // As a writer does: nothing that goes wrong is thrown at whoever waits.
  Status stored = success();
  try {
    stored = maybe_fail(StorageFault::Call::store);
    if (stored) {
      meshes_[pending.tile] = std::move(pending.mesh);
      stored = remove_beginnings(*this, pending.tile);
    }
  } catch (const std::exception& e) {
    stored = error(Errc::internal, e.what());
  }
  Result<TileEntry> entry = TileEntry{};
  if (stored) {
    entry.value().tile = pending.tile;
  } else {
    entry = stored.error();
  }
  const Turn theirs(memory_faults, true);
  pending.done(std::move(entry));
}

bool MemoryStorage::store_one(std::mt19937_64& rng) {
  if (pending_.empty()) return false;
  std::swap(pending_[rng() % pending_.size()], pending_.back());
  Pending pending = std::move(pending_.back());
  pending_.pop_back();
  store_now(std::move(pending));
  return true;
}

bool MemoryStorage::lose_pending() {
  const std::vector<Pending> lost = std::exchange(pending_, {});
  for (const Pending& pending : lost) pending.done(error(Errc::interrupted, "lost with the process"));
  return !lost.empty();
}

void MemoryStorage::damage(std::mt19937_64& rng) {
  if (scratch_.empty()) return;
  std::next(scratch_.begin(), static_cast<std::ptrdiff_t>(rng() % scratch_.size()))->second.damaged = true;
}

std::uint64_t MemoryStorage::take_reads() {
  std::uint64_t most = 0;
  for (const auto& [what, times] : std::exchange(reads_, {})) most = std::max(most, times);
  return most;
}

bool MemoryStorage::holds_mail() const {
  for (const auto& [key, held] : scratch_) {
    if (key.second == ScratchKind::mail) return true;
  }
  return false;
}

}  // namespace tessera
