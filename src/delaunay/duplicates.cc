#include "src/delaunay/duplicates.h"

#include <cstring>
#include <filesystem>

#include "src/base/files/frame.h"
#include "src/base/files/names.h"

namespace tessera {
namespace {

struct Found {
  std::vector<DuplicatePair> pairs;
  std::uint64_t other_heights = 0;
};

Result<Found> duplicates_of(const RoutedCloud& run, TileId tile, std::uint64_t count) {
  const auto bytes = read_frame(scratch_file(run.folder, ScratchKind::duplicates, tile), ScratchKind::duplicates,
                                {run.seal, tile.value});
  Found found;
  if (bytes && bytes.value().size() == (count + 1) * sizeof(DuplicatePair)) {
    found.pairs.resize(count + 1);
    std::memcpy(static_cast<void*>(found.pairs.data()), bytes.value().data(), bytes.value().size());
    found.other_heights = found.pairs.back().duplicate.value;
    found.pairs.pop_back();
    return found;
  }
  BOOST_OUTCOME_TRY(loaded, load_tile(run, tile));
  for (const auto& [duplicate, kept] : loaded.duplicates) found.pairs.push_back({duplicate, kept});
  found.other_heights = loaded.other_heights;
  return found;
}

}  // namespace

std::vector<std::pair<PointId, PointId>> duplicates_for_scratch(std::vector<std::pair<PointId, PointId>> duplicates,
                                                                std::uint64_t other_heights) {
  duplicates.emplace_back(PointId{other_heights}, PointId{0});
  return duplicates;
}

Result<std::uint64_t> gather_duplicates(const RoutedCloud& run, const std::vector<TileEntry>& tiles,
                                        DuplicateSort& out) {
  std::uint64_t other_heights = 0;
  for (const TileEntry& entry : tiles) {
    const std::uint64_t points = run.tile_points[entry.tile.value];
    if (entry.own_points == points) continue;
    BOOST_OUTCOME_TRY(found, duplicates_of(run, entry.tile, points - entry.own_points));
    other_heights += found.other_heights;
    for (const DuplicatePair& pair : found.pairs) {
      BOOST_OUTCOME_TRYV(out.push(pair));
    }
  }
  return other_heights;
}

}  // namespace tessera
