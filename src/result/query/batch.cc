#include "src/result/query/batch.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "src/base/on_threads.h"

namespace tessera::query {
namespace {

// Points of one tile that one thread takes.
struct Share {
  TileId tile;
  std::size_t begin, end;  // in the list of points by tile
};

constexpr std::size_t share_max = 1 << 14;

bool is_inside(const Bounds& bounds, const Period& period, const Point& p) {
  for (int axis = 0; axis < 3; ++axis)
    if (!period.along(axis) && !(bounds.lo[axis] <= p[axis] && p[axis] <= bounds.hi[axis])) return false;
  return true;
}

}  // namespace

Status locate_all(TileCache& cache, const Manifest& manifest, const Homes& homes, const Batch& batch,
                  const VisitLocated& visit) {
  const std::size_t n = batch.points.size();
  std::vector<TileId> tile(n);
  std::vector<std::uint32_t> order(n);
  std::vector<std::size_t> end;  // by tile
  for (std::size_t i = 0; i < n; ++i) {
    tile[i] = homes(batch.points[i]);
    if (tile[i].value >= end.size()) end.resize(tile[i].value + 1, 0);
    ++end[tile[i].value];
  }
  for (std::size_t t = 1; t < end.size(); ++t) end[t] += end[t - 1];
  std::vector<Share> shares;
  for (std::size_t t = 0, begin = 0; t < end.size(); begin = end[t++])
    for (std::size_t b = begin; b < end[t]; b += share_max)
      shares.push_back({TileId{static_cast<std::uint32_t>(t)}, b, std::min(b + share_max, end[t])});
  for (std::size_t i = n; i-- > 0;) order[--end[tile[i].value]] = static_cast<std::uint32_t>(i);

  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  const auto work = [&]() -> Status {
    Walker walker(cache, manifest, batch.with_rows);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
    for (std::size_t s = next++; s < shares.size() && !failed; s = next++) {
      if (batch.stop.stop_requested()) return error(Errc::interrupted, "interrupted while answering");
      keyed.clear();
      const QueryTile* home = nullptr;
      for (std::size_t k = shares[s].begin; k < shares[s].end; ++k) {
        const Point& q = batch.points[order[k]];
        if (!is_inside(manifest.bounds, batch.period, q)) {
          BOOST_OUTCOME_TRYV(visit(walker, order[k], Located{}));
          continue;
        }
        if (home == nullptr) {
          BOOST_OUTCOME_TRY(loaded, walker.tile(shares[s].tile));
          home = loaded;
        }
        keyed.emplace_back(home->key(q), order[k]);
      }
      std::sort(keyed.begin(), keyed.end());
      std::size_t from = 0;
      for (const auto& [key, i] : keyed) {
        BOOST_OUTCOME_TRY(here, walker.tile(shares[s].tile));
        CellRef at{here, here->start(batch.points[i], key, from)};
        BOOST_OUTCOME_TRY(located, walker.locate(batch.points[i], at));
        BOOST_OUTCOME_TRYV(visit(walker, i, located));
      }
      walker.keep_only(nullptr);
    }
    return success();
  };
  const auto useful = static_cast<unsigned>(std::min<std::size_t>(std::max(batch.threads, 1u), shares.size()));
  return on_threads(std::max(useful, 1u), failed, work);
}

}  // namespace tessera::query
