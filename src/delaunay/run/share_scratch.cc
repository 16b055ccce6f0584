#include "src/delaunay/run/share_scratch.h"

#include <atomic>
#include <set>
#include <string>

#include "src/base/files/free_space.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera {

namespace {

// A node with less free space is not used: it would fail with its first tiles.
constexpr std::uint64_t scratch_free_min = std::uint64_t{4} << 20;

}  // namespace

Result<std::filesystem::path> new_share_folder(const std::filesystem::path& scratch) {
  if (scratch.empty())
    return error(Errc::usage, "this node has no scratch folder: it cannot take part of a cluster's job");
  static std::atomic<std::uint64_t> number{0};
  if (const std::uint64_t free = free_bytes(scratch); free < scratch_free_min)
    return error(Errc::io, scratch.string() + ": only " + std::to_string(free >> 10) +
                               " KiB are free for tiles that are not in memory");
  auto folder = share_scratch_folder(scratch, number++);
  BOOST_OUTCOME_TRYV(make_directories(folder));
  return folder;
}

Result<bool> is_settled(const std::filesystem::path& run, const Share& share, std::uint32_t tiles,
                        const std::function<bool(TileId)>& here) {
  BOOST_OUTCOME_TRY(marked, is_there(settled_marker(stage_folder(run, share.table->stage))));
  if (!marked) return false;
  std::set<TileId> stored;
  for (const TileReceipt& tile : share.stored) stored.insert(tile.tile);
  const TileContext& context = share.stages.at(share.table->stage).context;
  for (std::uint32_t t = 0; t < tiles; ++t) {
    if (!here(TileId{t}) || stored.contains(TileId{t})) continue;
    BOOST_OUTCOME_TRY(alone, can_be_built_alone(*context.storage, TileId{t}, context.many_nodes));
    if (!alone) return false;
  }
  return true;
}

}  // namespace tessera
