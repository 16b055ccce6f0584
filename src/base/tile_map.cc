#include "src/base/tile_map.h"

#include <utility>

namespace tessera {

void TileMap::begin(TileLayout layout, const std::vector<std::uint64_t>& tile_points) {
  std::string stages;
  stages.reserve(tile_points.size());
  for (const auto points : tile_points)
    stages += static_cast<char>(points > 0 ? TileStatus::waiting : TileStatus::empty);
  const std::lock_guard lock(mutex_);
  layout_ = std::move(layout);
  stages_ = std::move(stages);
  begun_again_ = 0;
}

void TileMap::note_reached(TileId tile, TileStatus stage) {
  const std::lock_guard lock(mutex_);
  if (tile.value >= stages_.size()) return;  // of a run for which begin() was not called
  char& now = stages_[tile.value];
  if (stage == TileStatus::triangulated && now != static_cast<char>(TileStatus::waiting)) ++begun_again_;
  // The span in which a tile was stored may be reported after its storing.
  if (stage == TileStatus::splayed && now == static_cast<char>(TileStatus::stored)) return;
  now = static_cast<char>(stage);
}

TileLayout TileMap::layout() const {
  const std::lock_guard lock(mutex_);
  return layout_;
}

std::string TileMap::stages() const {
  const std::lock_guard lock(mutex_);
  return stages_;
}

std::uint64_t TileMap::begun_again() const {
  const std::lock_guard lock(mutex_);
  return begun_again_;
}

}  // namespace tessera
