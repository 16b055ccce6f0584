#include "src/delaunay/run/routed_shares.h"

#include <malloc.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <numeric>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/folder_lock.h"
#include "src/base/memory_pool.h"
#include "src/delaunay/delaunay_program.h"
#include "src/delaunay/disk_store.h"
#include "src/delaunay/run/early.h"
#include "src/delaunay/run/run_options.h"
#include "src/delaunay/run/share_scratch.h"
#include "src/delaunay/run/touching.h"
#include "src/exchange/disk_scratch.h"
#include "src/result/store/early_cells.h"
#include "src/tiling/budget/budget.h"

namespace tessera {
struct RoutedShares::DiskShare final : Share {
  // `scratch_folder`: empty, or a folder that is removed with the share.
  DiskShare(std::shared_ptr<const RoutedCloud> routed, std::filesystem::path scratch_folder,
            const std::filesystem::path& out, StoreOptions options, std::uint32_t writers, TileConsumer* taker,
            std::uint64_t pool_bytes)
      : run(routed),
        storage({routed->folder, scratch_folder.empty() ? routed->folder : scratch_folder, routed->seal,
                 options.lock_file, options.node}),
        store(routed_points(routed), out, with(options, stopping.get_token()), writers, storage, taker),
        pool(pool_bytes) {
    scratch = std::move(scratch_folder);
  }
  ~DiskShare() override {
    stopping.request_stop();
    if (!scratch.empty()) (void)remove_tree(scratch);  // what cannot be removed goes when the node starts anew
  }
  static StoreOptions with(StoreOptions store, std::stop_token stop) {
    store.stop = std::move(stop);
    return store;
  }
  std::shared_ptr<const RoutedCloud> run;
  DiskScratch storage;
  DiskStore store;
  MemoryPoolShare pool;
};

namespace {

// Returns a pointer to a part of the run that keeps the run alive.
template <class Of>
std::shared_ptr<const Of> shared(const std::shared_ptr<const RoutedCloud>& run, const Of& of) {
  return {run, &of};
}

}  // namespace

Result<std::vector<TileReceipt>> receipts_of(const std::filesystem::path& out,
                                             const std::function<bool(TileId)>& wanted) {
  std::vector<TileReceipt> stored;
  BOOST_OUTCOME_TRY(entries, stored_tiles(out, wanted));
  for (const TileEntry& entry : entries) stored.push_back({entry.tile, bytes_of(entry)});
  return stored;
}

void RoutedShares::offer(std::shared_ptr<const RoutedCloud> run, TileConsumer* taker) {
  const std::lock_guard lock(mutex_);
  auto folder = run->folder.string();
  offered_[std::move(folder)] = {std::move(run), taker};
}

void RoutedShares::withdraw(const RoutedCloud& run) noexcept {
  const std::lock_guard lock(mutex_);
  std::erase_if(offered_, [&](const auto& entry) { return entry.second.run.get() == &run; });
}

namespace {

// Of each tile that is the node's; 0 of the others.
Result<std::vector<std::uint64_t>> points_of_share(const ShareSpec& spec, const RoutedCloud& run, NodeId self) {
  if (!spec.table.nodes.empty() && spec.table.nodes.size() != run.tile_points.size())
    return error(Errc::internal, spec.run_folder + ": has another number of tiles than the job");
  if (spec.table.stage > 0)
    return error(Errc::internal, spec.run_folder + ": has only one stage, and the job asks for another");
  std::vector<std::uint64_t> points = run.tile_points;
  for (std::uint32_t t = 0; t < points.size(); ++t) {
    if (spec.table.node_of(TileId{t}) != self) points[t] = 0;
  }
  return points;
}

// Whether tiles give their final cells away early, so that all fit in memory.
bool reduces(const DelaunayOptions& how, const std::vector<std::uint64_t>& points, const RoutedCloud& run,
             TileKind kind, const ShareSpec& spec) {
  return how.keep == TileRetention::reduced ||
         (how.keep == TileRetention::by_budget &&
          !budget::fits_whole(points, run.dimension, how.kernel, kind, spec.threads, spec.memory_bytes));
}

// `beside`: bytes of the share's memory that are not for tiles.
ScheduleOptions schedule_of(const ShareSpec& spec, int dimension, KernelKind kernel, TileKind kind, bool reduce,
                            std::uint64_t tiles, std::uint64_t beside) {
  const budget::Needs needs = budget::needs(dimension, kernel, kind);
  ScheduleOptions schedule;
  schedule.threads = spec.threads;
  schedule.memory_bytes = budget::for_tiles(spec.memory_bytes - beside, spec.threads, tiles);
  schedule.begin_bytes = needs.triangulate;
  schedule.collect_bytes = reduce ? needs.collect : needs.collect_whole;
  schedule.sleep_percent = budget::sleep_percent(kernel);
  schedule.wake_percent = budget::wake_percent(kernel);
  schedule.mail_growth = static_cast<double>(budget::foreign_point_bytes(dimension, kernel)) / sizeof(SharedPoint);
  return schedule;
}

// What the tiles of a cloud have in common, without storage.
std::shared_ptr<DelaunayStage> stage_of(const std::shared_ptr<const RoutedCloud>& run, KernelKind kernel, TileKind kind,
                                        bool reduce) {
  auto stage = std::make_shared<DelaunayStage>();
  stage->dimension = run->dimension;
  stage->kernel = kernel;
  stage->reduce = reduce;
  stage->kind = kind;
  stage->early_unit = early_unit(run->dimension);
  const Period& period = run->partition.period();
  stage->boxes = final_boxes(shared(run, run->partition), period);
  stage->around = std::make_shared<const KnownFromStart>(shared(run, run->tile_bounds),
                                                         touching_tiles(run->partition, run->tile_bounds, period),
                                                         shared(run, run->seeds), period);
  return stage;
}

}  // namespace

Result<std::unique_ptr<Share>> RoutedShares::open(const ShareSpec& spec, NodeId self) {
  std::shared_ptr<const RoutedCloud> run;
  TileConsumer* taker = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = offered_.find(spec.run_folder); found != offered_.end()) {
      run = found->second.run;
      taker = found->second.taker;
    }
  }
  if (!run) {
    BOOST_OUTCOME_TRY(opened, open_run(spec.run_folder));
    run = std::make_shared<const RoutedCloud>(std::move(opened));
  }
  BOOST_OUTCOME_TRY(points, points_of_share(spec, *run, self));
  BOOST_OUTCOME_TRY(how, delaunay_options_from_bytes(spec.programs));
  const std::uint64_t cloud = std::accumulate(run->tile_points.begin(), run->tile_points.end(), std::uint64_t{0});
  const TileKind kind = kind_of_tiles(how.store, cloud);
  const bool reduce = reduces(how, points, *run, kind, spec);
  const bool many_nodes = spec.shares > 0;
  BOOST_OUTCOME_TRY(scratch, many_nodes ? new_share_folder(scratch_) : std::filesystem::path());
  // When memory is short, large blocks go straight back to the system instead of into the allocator's pools. The
  // allocator belongs to the process: once a job has asked for this, it stays so for all jobs, and costs them page
  // faults.
  if (reduce) mallopt(M_MMAP_THRESHOLD, 256 << 10);
  // The kernels' arrays go back to the system, too, except for a small pool in which a few of them take turns: fresh
  // pages from the system cost as much time as the work in them.
  const std::uint64_t pool_bytes = reduce ? spec.memory_bytes / 16 : spec.memory_bytes / 4;
  auto share = std::make_unique<DiskShare>(run, std::move(scratch), spec.out_folder,
                                           StoreOptions{.neighbors = how.neighbors,
                                                        .schema = run->schema,
                                                        .lock_file = spec.lock_file,
                                                        .node = self,
                                                        .sync = many_nodes},
                                           spec.threads + 1, taker, pool_bytes);  // one waits for the disk, mostly
  const auto tiles =
      static_cast<std::uint64_t>(std::count_if(points.begin(), points.end(), [](auto n) { return n > 0; }));
  ShareStage only;
  only.schedule = schedule_of(spec, run->dimension, how.kernel, kind, reduce, tiles,
                              (many_nodes ? budget::outbox_bytes(spec.memory_bytes) : 0) + (reduce ? pool_bytes : 0));
  TileContext& context = only.context;
  if (many_nodes) {
    std::uint64_t peers = 4;  // and some nodes that may join
    for (const NodeId node : spec.table.nodes) peers = std::max<std::uint64_t>(peers, node.value);
    share->outboxes = outboxes_within(budget::outbox_bytes(spec.memory_bytes), peers);
  }
  context.many_nodes = only.schedule.settle_asleep = many_nodes;
  if (many_nodes) only.sync_settled = [storage = &share->storage] { return storage->sync_settled(); };
  auto stage = stage_of(run, how.kernel, kind, reduce);
  stage->early_points = taker ? 0 : early_points_of(cloud);
  if (reduce) share->heap_trim.set_often(spec.memory_bytes / 256);
  share->table = std::make_shared<const RoutingTable>(spec.table);
  stage->storage = context.storage = &share->storage;
  stage->store = &share->store;
  stage->stop = share->stopping.get_token();
  context.programs = std::move(stage);
  context.mail_bytes_max = budget::mail_bytes_max(spec.memory_bytes, tiles);
  share->mail = std::make_unique<MailCounts>(
      map_regions_of(layout_of(run->partition, {}), run->tile_points.size(), MailCounts::regions_max));
  share->weights = shared(run, run->tile_points);
  share->stages.push_back(std::move(only));
  // Mail of an earlier process was for tiles that no longer exist.
  BOOST_OUTCOME_TRYV(share->storage.clear(ScratchKind::mail));
  const auto here = [&](TileId tile) { return tile.value < points.size() && points[tile.value] > 0; };
  BOOST_OUTCOME_TRY(stored, receipts_of(spec.out_folder, here));
  share->stored = std::move(stored);
  BOOST_OUTCOME_TRY(all_settled, is_settled(run->folder, *share, static_cast<std::uint32_t>(points.size()), here));
  share->settled = all_settled;
  return std::unique_ptr<Share>(std::move(share));
}

}  // namespace tessera
