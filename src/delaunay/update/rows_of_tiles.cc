#include "src/delaunay/update/rows_of_tiles.h"

#include <algorithm>
#include <cstring>
#include <map>

namespace tessera {

Result<std::shared_ptr<const RowsOfTiles::OfTile>> RowsOfTiles::read(TileId tile) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const auto& kept) { return kept->tile == tile; });
    if (found != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, found);
      return kept_.front();
    }
  }
  const auto index = source_.find(tile);
  if (!index) return std::shared_ptr<const OfTile>();
  BOOST_OUTCOME_TRY(stored, source_.read(*index, {.cells = false, .rows = true}));
  auto rows = std::make_shared<OfTile>();
  rows->tile = tile;
  rows->places.reserve(stored.mesh.ids.size());
  for (std::size_t v = 0; v < stored.mesh.ids.size(); ++v) rows->places[stored.mesh.ids[v]] = v;
  rows->rows = std::move(stored.rows);
  keep(rows);
  return std::shared_ptr<const OfTile>(std::move(rows));
}

void RowsOfTiles::keep(std::shared_ptr<const OfTile> rows) {
  const std::lock_guard lock(mutex_);
  kept_bytes_ += rows->bytes();
  kept_.push_front(std::move(rows));
  while (kept_bytes_ > memory_bytes_ && !kept_.empty()) {
    kept_bytes_ -= kept_.back()->bytes();
    kept_.pop_back();
  }
}

Result<std::vector<std::byte>> RowsOfTiles::of(TileId tile, std::span<const PointId> ids,
                                               std::span<const TileId> owners) {
  const std::size_t width = row_bytes(source_.manifest().schema);
  std::vector<std::byte> rows(ids.size() * width);
  if (width == 0) return rows;
  BOOST_OUTCOME_TRY(own, read(tile));
  std::map<TileId, std::vector<std::size_t>> elsewhere;  // places in `ids`
  const auto take = [&](const OfTile* from, std::size_t v) {
    if (from == nullptr) return false;
    const auto found = from->places.find(ids[v]);
    if (found == from->places.end()) return false;
    std::memcpy(&rows[v * width], &from->rows[found->second * width], width);
    return true;
  };
  for (std::size_t v = 0; v < ids.size(); ++v) {
    if (ids[v].value >= plan_->first_new) {
      std::memcpy(&rows[v * width], &plan_->rows[(ids[v].value - plan_->first_new) * width], width);
    } else if (const auto heir = plan_->heir_rows.find(ids[v]); heir != plan_->heir_rows.end()) {
      std::copy_n(heir->second.begin(), width, &rows[v * width]);
    } else if (!take(own.get(), v)) {
      elsewhere[owners[v]].push_back(v);
    }
  }
  for (const auto& [owner, vertices] : elsewhere) {
    BOOST_OUTCOME_TRY(theirs, read(owner));
    for (const std::size_t v : vertices) {
      if (!take(theirs.get(), v))
        return error(Errc::internal, "the attributes of point " + to_string(ids[v]) + " are not known");
    }
  }
  return rows;
}

}  // namespace tessera
