#include "src/run/duplicates.h"

#include <cstring>
#include <filesystem>

#include "src/files/frame.h"
#include "src/files/names.h"

namespace tessera {
namespace {

using Pairs = std::vector<DuplicatePair>;

Result<Pairs> pairs_of(const RoutedRun& run, TileId tile, std::uint64_t count) {
  const auto bytes = read_frame(scratch_file(run.folder, ScratchKind::duplicates, tile), ScratchKind::duplicates,
                                {run.seal, tile.value});
  if (bytes && bytes.value().size() == count * sizeof(DuplicatePair)) {
    Pairs pairs(count);
    std::memcpy(static_cast<void*>(pairs.data()), bytes.value().data(), bytes.value().size());
    return pairs;
  }
  BOOST_OUTCOME_TRY(loaded, load_tile(run, tile));
  Pairs pairs;
  for (const auto& [duplicate, kept] : loaded.duplicates) pairs.push_back({duplicate, kept});
  return pairs;
}

}  // namespace

Status gather_duplicates(const RoutedRun& run, const std::vector<TileEntry>& tiles, DuplicateSort& out) {
  for (const TileEntry& entry : tiles) {
    const std::uint64_t points = run.tile_points[entry.tile.value];
    if (entry.own_points == points) continue;
    BOOST_OUTCOME_TRY(pairs, pairs_of(run, entry.tile, points - entry.own_points));
    for (const DuplicatePair& pair : pairs) {
      BOOST_OUTCOME_TRYV(out.push(pair));
    }
  }
  return success();
}

}  // namespace tessera
