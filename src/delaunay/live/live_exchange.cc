#include "src/delaunay/live/live_exchange.h"

#include <algorithm>
#include <atomic>

#include "src/base/check.h"
#include "src/base/on_threads.h"
#include "src/base/too_large.h"

namespace tessera {

template <class Work>
Status LiveExchange::for_each(const std::vector<TileId>& tiles, const Work& work) {
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0};
  const auto threads = static_cast<unsigned>(std::min<std::size_t>(threads_, tiles.size()));
  return on_threads(std::max(threads, 1u), failed, [&]() -> Status {
    for (std::size_t i = next++; i < tiles.size() && !failed; i = next++) {
      try {
        BOOST_OUTCOME_TRYV(work(tiles[i], woken_.at(tiles[i])));
      } catch (const TileTooLarge& e) {
        return error(Errc::memory, "tile " + to_string(tiles[i]) + " " + e.what());
      } catch (const Unsound& e) {
        return error(Errc::corrupt, "tile " + to_string(tiles[i]) + ": " + e.what());
      }
    }
    return success();
  });
}

// The owners of removed and of new points, and of the neighbours of removed points.
std::set<TileId> LiveExchange::beginners() const {
  std::set<TileId> out;
  for (const auto& [tile, points] : batch_.added) out.insert(tile);
  std::vector<Vertex> around;
  for (const auto& [tile, ids] : batch_.removed) {
    out.insert(tile);
    const TileTriangulation& of_tile = before_.tiles()[tile.value]->triangulation();
    for (const PointId id : ids) {
      of_tile.kernel().neighbours(of_tile.vertex_of(id), around);
      for (const Vertex w : around) out.insert(of_tile.owner(w));
    }
  }
  return out;
}

// A foreign vertex that is in none of the tile's cells may have been removed while the tile slept. Then its owner does
// not have it any more.
Status LiveExchange::wake(TileId id, Woken& tile) const {
  const auto& stored = before_.tiles()[id.value];
  if (stored) {
    tile.triangulation = stored->triangulation().clone();
  } else {
    tile.triangulation = std::make_unique<TileTriangulation>(
        TileOptions{.self = id, .dimension = before_.partition().dimension(), .around = &around_});
    tile.triangulation->settle();
  }
  std::span<const LocalPoint> added;
  if (const auto found = batch_.added.find(id); found != batch_.added.end()) added = found->second;
  std::vector<PointId> removed = removed_;
  for (const SharedPoint& p : tile.triangulation->foreign_vertices()) {
    const auto& owner = before_.tiles()[p.tile.value];
    if (!owner || owner->triangulation().vertex_of(p.id) == 0) removed.push_back(p.id);
  }
  BOOST_OUTCOME_TRY(change, tile.triangulation->change(removed, added));
  tile.change = std::move(change);
  return success();
}

// Any old point that stays will do; a new one only when no old point stays.
std::optional<SharedPoint> LiveExchange::common() const {
  for (const auto& [id, tile] : woken_) {
    if (const auto old = tile.triangulation->old_point()) return old;
  }
  for (std::size_t i = 0; i < before_.tiles().size(); ++i) {
    if (woken_.contains(TileId{static_cast<std::uint32_t>(i)}) || !before_.tiles()[i]) continue;
    return before_.tiles()[i]->triangulation().old_point();
  }
  for (const auto& [id, tile] : woken_) {
    if (tile.triangulation->own_points() > 0) return tile.triangulation->new_point();
  }
  return std::nullopt;
}

// Each tile that begins knows the points around the holes in the tiles that touch it, as in UpdateExchange.
Status LiveExchange::begin() {
  constexpr std::size_t points_max = 4096;  // of one tile
  const auto common_point = common();
  std::vector<TileId> begin;
  std::map<TileId, std::vector<SharedPoint>> affected;
  for (const auto& [id, tile] : woken_) {
    if (!tile.change.begins) continue;
    begin.push_back(id);
    affected[id] = tile.triangulation->affected(points_max);
  }
  BOOST_OUTCOME_TRYV(for_each(begin, [&](TileId id, Woken& tile) -> Status {
    for (const TileId other : around_.neighbours(id)) {
      const auto beside = affected.find(other);
      if (beside == affected.end()) continue;
      BOOST_OUTCOME_TRYV(tile.triangulation->know(beside->second));
    }
    if (common_point) {
      BOOST_OUTCOME_TRYV(tile.triangulation->know_common(*common_point));
    }
    tile.triangulation->introduce();
    return success();
  }));
  for (const TileId id : begin) post(id);
  return success();
}

void LiveExchange::post(TileId from) {
  for (auto& [to, points] : woken_.at(from).triangulation->take_updates()) {
    mail_[to].emplace_back(from, std::move(points));
  }
}

Status LiveExchange::round() {
  const auto mail = std::exchange(mail_, {});
  std::vector<TileId> work;
  for (const auto& [to, messages] : mail) {
    work.push_back(to);
    woken_[to];
  }
  BOOST_OUTCOME_TRYV(for_each(work, [&](TileId id, Woken& tile) -> Status {
    if (!tile.triangulation) {
      tile.mailed = true;
      BOOST_OUTCOME_TRYV(wake(id, tile));
    }
    for (const auto& [from, points] : mail.at(id)) {
      BOOST_OUTCOME_TRYV(tile.triangulation->receive(from, points));
    }
    tile.triangulation->introduce();
    return success();
  }));
  for (const TileId id : work) post(id);
  return success();
}

Status LiveExchange::run() {
  const std::set<TileId> first = beginners();
  for (const TileId id : first) woken_[id];
  BOOST_OUTCOME_TRYV(for_each(std::vector<TileId>(first.begin(), first.end()),
                              [&](TileId id, Woken& tile) { return wake(id, tile); }));
  BOOST_OUTCOME_TRYV(begin());
  while (!mail_.empty()) {
    BOOST_OUTCOME_TRYV(round());
  }
  return success();
}

}  // namespace tessera
