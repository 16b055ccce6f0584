#include "src/delaunay/duplicates.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <span>

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

// The attributes are read for so many points at a time.
constexpr std::size_t rows_at_once = std::size_t{1} << 16;

Status gather_rows(ShuffleFileMaps& maps, TileId tile, const std::vector<DuplicatePair>& pairs, DuplicateRowSort& out) {
  for (std::size_t begin = 0; begin < pairs.size(); begin += rows_at_once) {
    std::vector<PointId> ids;
    for (std::size_t i = begin; i < std::min(begin + rows_at_once, pairs.size()); ++i)
      ids.push_back(pairs[i].duplicate);
    BOOST_OUTCOME_TRY(rows, load_rows(maps, tile, ids));
    for (std::size_t i = 0; i < ids.size(); ++i) {
      BOOST_OUTCOME_TRYV(out.push(ids[i], std::span(rows).subspan(i * out.width(), out.width())));
    }
  }
  return success();
}

}  // namespace

std::vector<std::pair<PointId, PointId>> duplicates_for_scratch(std::vector<std::pair<PointId, PointId>> duplicates,
                                                                std::uint64_t other_heights) {
  duplicates.emplace_back(PointId{other_heights}, PointId{0});
  return duplicates;
}

Result<std::uint64_t> gather_duplicates(const RoutedCloud& run, const std::vector<TileEntry>& tiles, DuplicateSort& out,
                                        DuplicateRowSort* rows) {
  std::uint64_t other_heights = 0;
  ShuffleFileMaps maps(run);
  for (const TileEntry& entry : tiles) {
    const std::uint64_t points = run.tile_points[entry.tile.value];
    if (entry.own_points == points) continue;
    BOOST_OUTCOME_TRY(found, duplicates_of(run, entry.tile, points - entry.own_points));
    other_heights += found.other_heights;
    for (const DuplicatePair& pair : found.pairs) {
      BOOST_OUTCOME_TRYV(out.push(pair));
    }
    if (rows != nullptr) {
      BOOST_OUTCOME_TRYV(gather_rows(maps, entry.tile, found.pairs, *rows));
    }
  }
  return other_heights;
}

}  // namespace tessera
