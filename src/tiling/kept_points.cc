#include "src/tiling/kept_points.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tessera {
namespace {

// Rows are read for so many points at a time, or for one point's duplicates if these are more.
constexpr std::size_t points_at_once = std::size_t{1} << 16;

double height_at(std::span<const std::byte> rows, std::size_t at) {
  double height = 0;
  std::memcpy(&height, rows.data() + at, sizeof height);
  return height;
}

using Pairs = std::vector<std::pair<PointId, PointId>>;  // (duplicate, kept)
using Pair = Pairs::value_type;

// Chooses the kept point of each vertex. choose() gets all pairs of some vertices, ordered by vertex. `replaced`
// collects the vertices whose first point is not the kept one.
class Chooser {
 public:
  Chooser(DuplicatePolicy keep, const HeightsOf& heights_of) : keep_(keep), heights_of_(heights_of) {}

  Status choose(std::span<Pair> pairs) {
    ids_.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (i == 0 || pairs[i].second != pairs[i - 1].second) ids_.push_back(pairs[i].second);
      ids_.push_back(pairs[i].first);
    }
    if (heights_of_) {
      std::sort(ids_.begin(), ids_.end());
      BOOST_OUTCOME_TRY(heights, heights_of_(ids_));
      heights_ = std::move(heights);
    }
    for (std::size_t begin = 0, end = 0; begin < pairs.size(); begin = end) {
      while (end < pairs.size() && pairs[end].second == pairs[begin].second) ++end;
      choose_one(pairs.subspan(begin, end - begin));
    }
    return success();
  }

  std::uint64_t other_heights() const { return other_heights_; }
  Pairs& replaced() { return replaced_; }  // (first, kept)

 private:
  KeptCandidate candidate(PointId id) const {
    if (!heights_of_) return {id};
    const auto at = std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin();
    return {id, heights_[static_cast<std::size_t>(at)]};
  }

  void choose_one(std::span<Pair> pairs) {
    const PointId first = pairs[0].second;
    KeptCandidate kept = candidate(first);
    for (const Pair& pair : pairs)
      if (const auto other = candidate(pair.first); is_kept_before(keep_, other, kept)) kept = other;
    for (Pair& pair : pairs) pair = {pair.first == kept.id ? first : pair.first, kept.id};
    if (kept.id != first) replaced_.emplace_back(first, kept.id);
    if (!heights_of_) return;
    for (const Pair& pair : pairs) other_heights_ += !is_same_height(candidate(pair.first).height, kept.height);
  }

  DuplicatePolicy keep_;
  const HeightsOf& heights_of_;
  std::vector<PointId> ids_;
  std::vector<double> heights_;
  std::uint64_t other_heights_ = 0;
  Pairs replaced_;
};

}  // namespace

std::optional<std::size_t> height_offset(int dimension, const std::vector<Attribute>& schema) {
  std::size_t at = 0;
  for (const Attribute& attribute : schema) {
    if (dimension == 2 && attribute.name == "z" && attribute.type == AttributeType::f64) return at;
    at += size_of(attribute.type);
  }
  return std::nullopt;
}

Status choose_kept(DuplicatePolicy keep, const HeightsOf& heights_of, LoadedTile& tile) {
  Pairs& pairs = tile.duplicates;
  if (pairs.empty() || (!heights_of && keep == DuplicatePolicy::first)) return success();
  const auto by_kept = [](const Pair& a, const Pair& b) {
    return std::pair(a.second, a.first) < std::pair(b.second, b.first);
  };
  std::sort(pairs.begin(), pairs.end(), by_kept);
  Chooser chooser(keep, heights_of);
  for (std::size_t begin = 0, end = 0; begin < pairs.size(); begin = end) {
    while (end < pairs.size() && (end - begin < points_at_once || pairs[end].second == pairs[end - 1].second)) ++end;
    BOOST_OUTCOME_TRYV(chooser.choose(std::span(pairs).subspan(begin, end - begin)));
  }
  tile.other_heights = chooser.other_heights();
  std::sort(pairs.begin(), pairs.end());
  const Pairs& replaced = chooser.replaced();  // ascending, as the vertices were
  if (replaced.empty()) return success();
  for (PointId& id : tile.ids) {
    const auto found = std::lower_bound(replaced.begin(), replaced.end(), Pair{id, PointId{0}});
    if (found != replaced.end() && found->first == id) id = found->second;
  }
  return success();
}

Status choose_kept(const RoutedCloud& run, TileId tile, LoadedTile& loaded) {
  const auto z = height_offset(run.dimension, run.schema);
  if (!z) return choose_kept(run.keep, {}, loaded);
  ShuffleFileMaps maps(run);
  const std::size_t row = row_bytes(run.schema);
  return choose_kept(
      run.keep,
      [&](std::span<const PointId> ids) -> Result<std::vector<double>> {
        BOOST_OUTCOME_TRY(rows, load_rows(maps, tile, {ids.begin(), ids.end()}));
        std::vector<double> heights(ids.size());
        for (std::size_t i = 0; i < ids.size(); ++i) heights[i] = height_at(rows, i * row + *z);
        return heights;
      },
      loaded);
}

Status choose_kept_seeds(RoutedCloud& run, const std::stop_token& stop) {
  if (run.keep == DuplicatePolicy::first) return success();
  const auto z = height_offset(run.dimension, run.schema);
  const std::size_t row = row_bytes(run.schema);
  for (std::size_t begin = 0, end = 0; begin < run.seeds.size(); begin = end) {
    const TileId tile = run.seeds[begin].point.tile;
    while (end < run.seeds.size() && run.seeds[end].point.tile == tile) ++end;
    const auto seeds = std::span(run.seeds).subspan(begin, end - begin);
    std::vector<std::optional<KeptCandidate>> kept(seeds.size());
    BOOST_OUTCOME_TRYV(
        for_each_record(run.files(), run.segments_of(tile), stop, [&](const auto points, const auto rows) -> Status {
          for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t s = 0; s < seeds.size(); ++s) {
              if (points[i].at != seeds[s].point.at) continue;
              const KeptCandidate other{points[i].id, z ? height_at(rows, i * row + *z) : 0};
              if (!kept[s] || is_kept_before(run.keep, other, *kept[s])) kept[s] = other;
            }
          }
          return success();
        }));
    for (std::size_t s = 0; s < seeds.size(); ++s)
      if (kept[s]) seeds[s].point.id = kept[s]->id;
    std::sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) { return a.point.id < b.point.id; });
  }
  return success();
}

}  // namespace tessera
