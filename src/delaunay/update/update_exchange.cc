#include "src/delaunay/update/update_exchange.h"

#include <algorithm>
#include <atomic>
#include <optional>

#include "src/base/on_threads.h"
#include "src/base/stopped.h"

namespace tessera {

template <class Work>
Status UpdateExchange::for_each(const std::vector<TileId>& tiles, const Work& work) {
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0};
  const auto threads = static_cast<unsigned>(std::min<std::size_t>(threads_, tiles.size()));
  return on_threads(std::max(threads, 1u), failed, [&]() -> Status {
    for (std::size_t i = next++; i < tiles.size() && !failed; i = next++) {
      throw_if_stopped(setting_.stop);
      BOOST_OUTCOME_TRYV(work(*tiles_.at(tiles[i])));
    }
    return success();
  });
}

Status UpdateExchange::read(const std::set<TileId>& wanted) {
  std::vector<TileId> unread;
  for (const TileId tile : wanted) {
    if (tiles_.contains(tile)) continue;
    tiles_[tile] = std::make_unique<WokenTile>(tile, setting_);
    unread.push_back(tile);
  }
  return for_each(unread, [](WokenTile& tile) { return tile.read(); });
}

// The owners of affected points are known from the cells of the owners of removed points.
Status UpdateExchange::read_beginners() {
  std::set<TileId> wanted = setting_.plan.losing;
  for (const auto& [tile, points] : setting_.plan.added) wanted.insert(tile);
  BOOST_OUTCOME_TRYV(read(wanted));
  std::set<TileId> beside;
  for (const auto& [id, tile] : tiles_) beside.insert(tile->beside_removed().begin(), tile->beside_removed().end());
  return read(beside);
}

// Any old point that stays will do; a new one only when no old point stays.
Status UpdateExchange::choose_common() {
  for (const auto& [id, tile] : tiles_) {
    if (!common_) common_ = tile->old_point();
  }
  for (std::size_t i = 0; i < setting_.source.tiles() && !common_; ++i) {
    const TileEntry& entry = setting_.source.entry(i);
    if (tiles_.contains(entry.tile) || entry.own_points == 0) continue;
    BOOST_OUTCOME_TRY(stored, setting_.source.read(i, {.cells = false}));  // the tile has lost nothing
    common_ = SharedPoint{stored.mesh.points.at(0), stored.mesh.ids.at(0), entry.tile, 0};
  }
  for (const auto& [id, tile] : tiles_) {
    if (!common_ && !tile->empty()) common_ = tile->new_point();
  }
  return success();
}

// Where points were removed at a border, a tile no longer knows what is beyond. It would take far points for its
// neighbours, and wake tile after tile. So it knows from the start the points around the holes in the tiles that touch
// it. Without this the removal of 100 points where 8 of 64 tiles meet woke all tiles.
void UpdateExchange::tell_of_holes(const std::vector<TileId>& beginners) {
  constexpr std::size_t points_max = 4096;  // of one tile
  std::map<TileId, std::vector<SharedPoint>> affected;
  for (const TileId id : beginners) affected[id] = tiles_.at(id)->affected(points_max);
  for (const TileId id : beginners) {
    std::vector<SharedPoint> beside;
    for (const TileId other : setting_.around.neighbours(id)) {
      const auto found = affected.find(other);
      if (found != affected.end()) beside.insert(beside.end(), found->second.begin(), found->second.end());
    }
    tiles_.at(id)->know(beside);
  }
}

Status UpdateExchange::begin() {
  std::vector<TileId> beginners;
  for (const auto& [id, tile] : tiles_) {
    if (tile->begins()) beginners.push_back(id);
  }
  tell_of_holes(beginners);
  BOOST_OUTCOME_TRYV(for_each(beginners, [&](WokenTile& tile) -> Status {
    BOOST_OUTCOME_TRYV(tile.begin(common_));
    return tile.step({});
  }));
  for (const TileId id : beginners) post(id);
  return success();
}

void UpdateExchange::post(TileId from) {
  for (auto& [to, points] : tiles_.at(from)->take_updates()) mail_[to].emplace_back(from, std::move(points));
}

Status UpdateExchange::round() {
  const auto mail = std::exchange(mail_, {});
  std::set<TileId> wanted;
  for (const auto& [to, messages] : mail) wanted.insert(to);
  BOOST_OUTCOME_TRYV(read(wanted));
  std::vector<TileId> work(wanted.begin(), wanted.end());
  BOOST_OUTCOME_TRYV(for_each(work, [&](WokenTile& tile) -> Status {
    if (!tile.awake()) {
      BOOST_OUTCOME_TRYV(tile.begin(std::nullopt));
    }
    return tile.step(mail.at(tile.self()));
  }));
  for (const TileId id : work) post(id);
  return success();
}

Status UpdateExchange::run() {
  BOOST_OUTCOME_TRYV(read_beginners());
  BOOST_OUTCOME_TRYV(choose_common());
  BOOST_OUTCOME_TRYV(begin());
  while (!mail_.empty()) {
    BOOST_OUTCOME_TRYV(round());
  }
  std::vector<TileId> others;
  for (const auto& [id, tile] : tiles_) {
    if (tile->lost() && !tile->empty() && !tile->awake()) others.push_back(id);
  }
  return for_each(others, [](WokenTile& tile) { return tile.begin(std::nullopt); });
}

}  // namespace tessera
