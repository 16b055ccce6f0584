#include "src/delaunay/run/result_shares.h"

#include <algorithm>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/delaunay/run/share_scratch.h"
#include "src/exchange/disk_scratch.h"
#include "src/tiling/budget/budget.h"

namespace tessera {

namespace {

// Returns the memory for tiles that no thread works on. As much is for tiles that are worked on, and the rest for mail.
constexpr std::uint64_t kept_part(std::uint64_t memory_bytes) { return memory_bytes / 8 * 3; }

struct ResultShare final : Share {
  ~ResultShare() override {
    stopping.request_stop();
    stages.clear();                                    // programs go before what they use
    if (!scratch.empty()) (void)remove_tree(scratch);  // what cannot be removed goes when the node starts anew
  }
  std::shared_ptr<const void> keeper;  // goes last
  std::vector<std::byte> plan;
  std::vector<std::unique_ptr<DiskScratch>> storages;  // by stage
};

}  // namespace

std::uint64_t seal_of_plan(std::span<const std::byte> plan) { return checksum(plan); }

std::vector<std::uint64_t> weights_of(const TileSource& source) {
  std::vector<std::uint64_t> weights;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const TileEntry& entry = source.entry(i);
    weights.resize(std::max<std::size_t>(weights.size(), entry.tile.value + std::size_t{1}), 0);
    weights[entry.tile.value] = std::max<std::uint64_t>(entry.own_points, 1);
  }
  return weights;
}

Result<std::vector<std::uint64_t>> ResultStages::weights(const TileSource& source, const std::filesystem::path&,
                                                         std::span<const std::byte>) const {
  return weights_of(source);
}

std::uint64_t bytes_a_point(const ResultStages& stages, const TileSource& source) {
  std::uint64_t most = 1;
  for (std::size_t i = 0; i < source.tiles(); ++i)
    most = std::max(most, stages.work_bytes(source, i) / std::max<std::uint64_t>(source.entry(i).own_points, 1) + 1);
  return most;
}

Result<std::shared_ptr<const ResultStages>> ResultShares::kind(const std::string& name) const {
  const auto found = kinds_.find(name);
  if (found == kinds_.end()) return error(Errc::internal, "this node cannot run jobs of the kind " + name);
  return found->second;
}

void ResultShares::offer(const std::filesystem::path& run, std::shared_ptr<const void> keeper) {
  const std::lock_guard lock(mutex_);
  keepers_[run.string()] = std::move(keeper);
}

void ResultShares::withdraw(const std::filesystem::path& run) noexcept {
  const std::lock_guard lock(mutex_);
  std::erase_if(keepers_, [&](const auto& entry) { return entry.first == run.native(); });
}

Result<std::unique_ptr<Share>> ResultShares::open(const ShareSpec& spec, NodeId self) {
  const std::filesystem::path run = spec.run_folder;
  BOOST_OUTCOME_TRY(stages, kind(spec.stages));
  BOOST_OUTCOME_TRY(source, TileSource::open(spec.out_folder));
  if (spec.table.stage >= stages->count())
    return error(Errc::internal, run.string() + ": does not have the stage that the job asks for");
  BOOST_OUTCOME_TRY(plan, read_whole(plan_file(run)));
  BOOST_OUTCOME_TRY(weights, stages->weights(source, run, plan));
  if (!spec.table.nodes.empty() && spec.table.nodes.size() != weights.size())
    return error(Errc::internal, spec.out_folder + ": has another number of tiles than the job");
  const auto here = [&](TileId tile) {
    return tile.value < weights.size() && weights[tile.value] > 0 && spec.table.node_of(tile) == self;
  };
  const auto tiles =
      static_cast<std::uint64_t>(std::count_if(weights.begin(), weights.end(), [](auto w) { return w > 0; }));
  auto share = std::make_unique<ResultShare>();
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = keepers_.find(spec.run_folder); found != keepers_.end()) share->keeper = found->second;
  }
  share->plan = std::move(plan);
  const std::uint64_t seal = seal_of_plan(share->plan);
  const bool many_nodes = spec.shares > 0;
  if (many_nodes) {
    BOOST_OUTCOME_TRY(scratch, new_share_folder(scratch_));
    share->scratch = std::move(scratch);
    std::uint64_t peers = 4;  // and some nodes that may join
    for (const NodeId node : spec.table.nodes) peers = std::max<std::uint64_t>(peers, node.value);
    share->outboxes = outboxes_within(budget::outbox_bytes(spec.memory_bytes), peers);
  }
  const auto own = many_nodes ? share->scratch : run;
  const std::uint64_t kept = kept_part(spec.memory_bytes);
  ShareStage one;
  one.schedule.threads = spec.threads;
  const std::uint64_t others = kept + (many_nodes ? budget::outbox_bytes(spec.memory_bytes) : 0);
  one.schedule.memory_bytes = budget::for_tiles(spec.memory_bytes - others, spec.threads, tiles);
  one.schedule.begin_bytes = one.schedule.collect_bytes = bytes_a_point(*stages, source);
  one.schedule.mail_growth = 1.5;
  stages->adjust(one.schedule, source);
  one.schedule.settle_asleep = one.context.many_nodes = many_nodes;
  one.context.mail_bytes_max = budget::mail_bytes_max(spec.memory_bytes, tiles);
  BOOST_OUTCOME_TRY(programs,
                    stages->programs({source.stopped_by(share->stopping.get_token()), run, own, share->plan, seal, self,
                                      kept, share->stopping.get_token(), spec.threads, one.schedule.memory_bytes}));
  for (std::uint32_t stage = 0; stage < stages->count(); ++stage) {
    DiskScratch& storage = *share->storages.emplace_back(std::make_unique<DiskScratch>(
        DiskScratchOptions{stage_folder(run, stage), stage_folder(own, stage), seal, spec.lock_file, self}));
    one.context.storage = &storage;
    one.context.programs = std::move(programs.at(stage));
    if (many_nodes) one.sync_settled = [&storage] { return storage.sync_settled(); };
    // Mail of an earlier process was for tiles that no longer exist.
    BOOST_OUTCOME_TRYV(storage.clear(ScratchKind::mail));
    share->stages.push_back(one);
  }
  share->table = std::make_shared<const RoutingTable>(spec.table);
  BOOST_OUTCOME_TRY(stored, stages->stored(run, spec.table.stage));
  std::copy_if(stored.begin(), stored.end(), std::back_inserter(share->stored),
               [&](const TileReceipt& tile) { return here(tile.tile); });
  BOOST_OUTCOME_TRY(settled, is_settled(run, *share, static_cast<std::uint32_t>(weights.size()), here));
  share->settled = settled;
  share->weights = std::make_shared<const std::vector<std::uint64_t>>(std::move(weights));
  return std::unique_ptr<Share>(std::move(share));
}

}  // namespace tessera
