#include "actors/harness/memory_storage.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <new>
#include <span>
#include <stdexcept>
#include <utility>

#include "src/base/check.h"
#include "src/result/store/digest.h"
#include "src/tiling/tile/rebuild.h"

namespace tessera {

Status MemoryStorage::maybe_fail(StorageFault::Call call) {
  if (!fault || fault->call != call || fault->countdown-- > 0) return success();
  const auto how = fault->how;
  fault.reset();
  if (how == StorageFault::How::exception) throw std::runtime_error("the harness's storage throws");
  if (how == StorageFault::How::no_memory) throw std::bad_alloc();
  return error(Errc::io, "the harness's storage fails");
}

Status MemoryStorage::maybe_fail(StorageFault::Call call, NodeId node, ScratchKind what) {
  const Status failed = maybe_fail(call);
  const bool own = many_nodes && what != ScratchKind::settled && what != ScratchKind::duplicates;
  if (failed || !own) return failed;
  failed_.insert(node);
  return failed;
}

class MemoryStorage::AtNode final : public TileStorage, public DelaunayStore {
 public:
  AtNode(MemoryStorage& all, NodeId node, std::uint32_t stage) : all_(all), node_(node), stage_(stage) {}

  Result<LoadedTile> load_points(TileId tile) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::load));
    ++all_.reads_[{stage_, tile, {}}];
    return order_points(all_.points_[tile.value], all_.dimension_);
  }

  Status write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::write, node_, what));
    all_.scratch_[key_of(node_, stage_, tile, what)] = {{{bytes.begin(), bytes.end()}}, false};
    return success();
  }

  Status append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::append, node_, what));
    all_.scratch_[key_of(node_, stage_, tile, what)].pieces.emplace_back(bytes.begin(), bytes.end());
    ++all_.spills_;
    return success();
  }

  Result<Pieces> read(TileId tile, ScratchKind what) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::read, node_, what));
    const auto found = all_.scratch_.find(key_of(node_, stage_, tile, what));
    if (found == all_.scratch_.end()) return Pieces{};
    ++all_.reads_[{stage_, tile, what}];
    if (found->second.damaged) return error(Errc::corrupt, "the harness has damaged it");
    return found->second.pieces;
  }

  Result<bool> has(TileId tile, ScratchKind what) override {
    return all_.scratch_.contains(key_of(node_, stage_, tile, what));
  }

  Status remove(TileId tile, ScratchKind what) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::remove, node_, what));
    all_.scratch_.erase(key_of(node_, stage_, tile, what));
    return success();
  }

  Status hand_over(TileId tile, std::span<const std::byte> bytes) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::write));
    all_.scratch_[handed_key(stage_, tile)] = {{{bytes.begin(), bytes.end()}}, false};
    return success();
  }

  Result<Pieces> handed(TileId tile) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::read));
    const auto found = all_.scratch_.find(handed_key(stage_, tile));
    if (found == all_.scratch_.end()) {
      ++all_.begun_[{stage_, tile}];
      return Pieces{};
    }
    if (found->second.damaged) return error(Errc::corrupt, "the harness has damaged it");
    return found->second.pieces;
  }

  bool own_scratch_failed() const override { return all_.failed_.contains(node_); }

  Status forget_handed(TileId tile) override {
    const Turn ours(all_.memory_faults, false);
    all_.scratch_.erase(handed_key(stage_, tile));
    return success();
  }

  Status clear(ScratchKind what) override {
    const Turn ours(all_.memory_faults, false);
    const auto node = key_of(node_, stage_, {}, what).node;
    std::erase_if(all_.scratch_, [&](const auto& entry) {
      const StorageKey& key = entry.first;
      return key.node == node && key.what == what && key.stage == stage_;
    });
    return success();
  }

  std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) override {
    const Turn ours(all_.memory_faults, false);
    std::promise<StoredEarly> promise;
    promise.set_value(keep_early(tile, *cells));
    return promise.get_future();
  }

  Status take_early(TileId tile, BigVector<std::byte>& stored) override {
    const Turn ours(all_.memory_faults, false);
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::read));
    auto kept = all_.early_.extract({tile, node_of(stored)});
    if (!kept) return error(Errc::corrupt, "the harness has damaged it");
    all_.early_[{tile, node_}] = std::move(kept.mapped());
    stored = name_of(node_);
    return success();
  }

  void store(TileId tile, CollectedTile collected, Finished::Stored done) override {
    const Turn ours(all_.memory_faults, false);
    Early early;
    if (collected.early > 0) {
      const auto kept = all_.early_.find({tile, node_of(collected.stored)});
      if (kept == all_.early_.end()) return done(error(Errc::corrupt, "the harness has damaged it"));
      early = kept->second;
    }
    store_mesh({node_, tile, std::move(collected).whole(early.vertices, early.neighbors), std::move(done)});
  }

  // Keeps the mesh that follows from the points, after a check that it is what was counted.
  void store_points(TileId tile, PointsOfTile kept, Finished::Stored done) override {
    const Turn ours(all_.memory_faults, false);
    const int dimension = all_.dimension_;
    Digest digest = kept.counted.digest;
    digest += digest_of(dimension, kept.points, kept.ids);
    const std::uint64_t own = kept.points.size();
    auto owners = kept.append_foreign(tile);
    auto mesh = rebuild({.dimension = dimension,
                         .self = tile,
                         .own = own,
                         .points = std::move(kept.points),
                         .ids = std::move(kept.ids),
                         .owners = std::move(owners)});
    if (!mesh) return done(mesh.error());
    const auto& ghosts = mesh.value().cell_ghost;
    if (digest_of(mesh.value()) != digest || ghosts.size() != kept.counted.cells ||
        static_cast<std::uint64_t>(std::count(ghosts.begin(), ghosts.end(), 0)) != kept.counted.main_cells)
      return done(error(Errc::internal, "other cells follow from what was kept than were counted"));
    store_mesh({node_, tile, std::move(mesh).value(), std::move(done)});
  }

 private:
  void store_mesh(Pending pending) {
    if (!all_.late_stores) return all_.store_now(std::move(pending));
    all_.pending_.push_back(std::move(pending));
  }

  static BigVector<std::byte> name_of(NodeId node) {
    const auto bytes = std::as_bytes(std::span(&node, 1));
    return {bytes.begin(), bytes.end()};
  }
  static NodeId node_of(std::span<const std::byte> name) {
    NodeId node;
    check(name.size() == sizeof node, "what was said of early cells");
    std::memcpy(&node, name.data(), sizeof node);
    return node;
  }

  StoredEarly keep_early(TileId tile, const EarlyFinals& cells) {
    BOOST_OUTCOME_TRYV(all_.maybe_fail(StorageFault::Call::store));
    Early& early = all_.early_[{tile, node_}] = {};
    const auto into = [](std::vector<std::int32_t>& list) {
      return [&list](std::span<const std::int32_t> piece) -> Status {
        list.insert(list.end(), piece.begin(), piece.end());
        return success();
      };
    };
    BOOST_OUTCOME_TRYV(cells.vertices(into(early.vertices)));
    BOOST_OUTCOME_TRYV(cells.neighbors(into(early.neighbors)));
    return name_of(node_);
  }

  static StorageKey handed_key(std::uint32_t stage, TileId tile) { return {{}, tile, ScratchKind::state, stage}; }

  MemoryStorage& all_;
  NodeId node_;
  std::uint32_t stage_;
};

MemoryStorage::MemoryStorage(int dimension, std::vector<std::vector<LocalPoint>> points)
    : dimension_(dimension), points_(std::move(points)) {}

MemoryStorage::~MemoryStorage() = default;

TileStorage& MemoryStorage::at(NodeId node, std::uint32_t stage) { return view_of(node, stage); }

DelaunayStore& MemoryStorage::store_at(NodeId node) { return view_of(node, 0); }

MemoryStorage::AtNode& MemoryStorage::view_of(NodeId node, std::uint32_t stage) {
  auto& view = views_[{node, stage}];
  if (!view) view = std::make_unique<AtNode>(*this, node, stage);
  return *view;
}

MemoryStorage::StorageKey MemoryStorage::key_of(NodeId node, std::uint32_t stage, TileId tile, ScratchKind what) {
  if (what == ScratchKind::settled) return {{}, tile, what, stage};
  return {node, tile, what, stage};
}

void MemoryStorage::forget_settled(std::uint32_t stage) {
  std::erase_if(scratch_, [&](const auto& entry) {
    return entry.first.what == ScratchKind::settled && entry.first.stage == stage;
  });
}

void MemoryStorage::store_now(Pending pending) {
  const Turn ours(memory_faults, false);
  // As a writer does: no exception reaches the caller.
  Status stored = success();
  try {
    stored = maybe_fail(StorageFault::Call::store);
    if (stored) {
      meshes_[pending.tile] = std::move(pending.mesh);
      stored = remove_beginnings(at(pending.node), pending.tile);
    }
  } catch (const std::exception& e) {
    stored = error(Errc::internal, e.what());
  }
  const Turn theirs(memory_faults, true);
  if (!stored) return pending.done(stored.error());
  pending.done(Receipt());
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
  if (!early_.empty() && rng() % 4 == 0) {
    early_.erase(std::next(early_.begin(), static_cast<std::ptrdiff_t>(rng() % early_.size())));
    return;
  }
  if (scratch_.empty()) return;
  std::next(scratch_.begin(), static_cast<std::ptrdiff_t>(rng() % scratch_.size()))->second.damaged = true;
}

std::uint64_t MemoryStorage::take_reads() {
  std::uint64_t most = 0;
  for (const auto& [what, times] : std::exchange(reads_, {})) most = std::max(most, times);
  return most;
}

std::uint64_t MemoryStorage::take_begun() {
  std::uint64_t most = 0;
  for (const auto& [tile, times] : std::exchange(begun_, {})) most = std::max(most, times);
  return most;
}

std::vector<TileReceipt> MemoryStorage::stored() const {
  std::vector<TileReceipt> stored;
  for (const auto& [tile, mesh] : meshes_) stored.push_back({tile, {}});
  return stored;
}

bool MemoryStorage::holds_mail() const {
  for (const auto& [key, held] : scratch_) {
    if (key.what == ScratchKind::mail) return true;
  }
  return false;
}

}  // namespace tessera
