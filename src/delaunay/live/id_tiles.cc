#include "src/delaunay/live/id_tiles.h"

#include <algorithm>

namespace tessera {

IdTiles IdTiles::with(std::vector<Entry> entries) const {
  IdTiles out = *this;
  if (entries.empty()) return out;
  std::sort(entries.begin(), entries.end());
  auto made = std::make_shared<List>();
  made->ids.reserve(entries.size());
  made->tiles.reserve(entries.size());
  for (const auto& [id, tile] : entries) {
    made->ids.push_back(id);
    made->tiles.push_back(tile);
  }
  while (!out.lists_.empty() && out.lists_.back()->ids.size() < 2 * made->ids.size()) {
    const List &a = *out.lists_.back(), b = std::move(*made);
    made = std::make_shared<List>();
    made->ids.reserve(a.ids.size() + b.ids.size());
    made->tiles.reserve(a.ids.size() + b.ids.size());
    for (std::size_t i = 0, k = 0; i < a.ids.size() || k < b.ids.size();) {
      const bool first = k == b.ids.size() || (i < a.ids.size() && a.ids[i] < b.ids[k]);
      const List& from = first ? a : b;
      std::size_t& at = first ? i : k;
      made->ids.push_back(from.ids[at]);
      made->tiles.push_back(from.tiles[at++]);
    }
    out.lists_.pop_back();
  }
  out.lists_.push_back(std::move(made));
  return out;
}

std::optional<TileId> IdTiles::find(PointId id) const {
  for (auto list = lists_.rbegin(); list != lists_.rend(); ++list) {
    const auto at = std::lower_bound((*list)->ids.begin(), (*list)->ids.end(), id);
    if (at != (*list)->ids.end() && *at == id)
      return (*list)->tiles[static_cast<std::size_t>(at - (*list)->ids.begin())];
  }
  return std::nullopt;
}

std::size_t IdTiles::size() const {
  std::size_t entries = 0;
  for (const auto& list : lists_) entries += list->ids.size();
  return entries;
}

std::size_t IdTiles::memory() const { return size() * (sizeof(PointId) + sizeof(TileId)); }

}  // namespace tessera
