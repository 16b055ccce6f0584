#include "src/delaunay/live/live_rows.h"

#include <algorithm>

namespace tessera {

void LiveRows::promote(PointId duplicate) {
  if (const auto row = duplicates_.extract(duplicate)) unstored_.insert({duplicate, row.mapped()});
}

void LiveRows::remove(PointId id) {
  unstored_.erase(id);
  duplicates_.erase(id);
}

// Without the attributes of all duplicates none are stored, and the result opened again must refuse what this one
// refuses.
void LiveRows::store(std::span<const DuplicatePair> duplicates) {
  for (const DuplicatePair& pair : complete_ ? duplicates : std::span<const DuplicatePair>()) {
    if (auto row = unstored_.extract(pair.duplicate)) duplicates_.insert(std::move(row));
  }
  unstored_.clear();
}

const std::vector<std::byte>* LiveRows::find(PointId id) const {
  for (const Rows* rows : {&unstored_, &duplicates_}) {
    if (const auto found = rows->find(id); found != rows->end()) return &found->second;
  }
  return nullptr;
}

RowsOfTile::RowsOfTile(std::span<const PointId> ids, std::vector<std::byte> rows) : rows_(std::move(rows)) {
  places_.reserve(ids.size());
  for (const PointId id : ids) places_.emplace_back(id, static_cast<std::uint32_t>(places_.size()));
  std::sort(places_.begin(), places_.end());
}

std::span<const std::byte> RowsOfTile::find(PointId id) const {
  const auto at = std::lower_bound(places_.begin(), places_.end(), std::pair(id, std::uint32_t{0}));
  if (at == places_.end() || at->first != id) return {};
  const std::size_t width = rows_.size() / places_.size();
  return std::span(rows_).subspan(at->second * width, width);
}

Result<std::shared_ptr<const RowsOfTile>> StoredRows::of(TileId tile) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = kept_.find(tile); found != kept_.end()) return found->second;
  }
  std::shared_ptr<const RowsOfTile> rows;
  if (const auto index = source_.find(tile)) {
    BOOST_OUTCOME_TRY(stored, source_.read(*index, {.cells = false, .rows = true}));
    rows = std::make_shared<const RowsOfTile>(stored.mesh.ids, std::move(stored.rows));
  } else {
    rows = std::make_shared<const RowsOfTile>(std::span<const PointId>(), std::vector<std::byte>());
  }
  const std::lock_guard lock(mutex_);
  if (bytes_ + rows->bytes() > kept_bytes) {
    kept_.clear();
    bytes_ = 0;
  }
  if (kept_.emplace(tile, rows).second) bytes_ += rows->bytes();
  return rows;
}

}  // namespace tessera
