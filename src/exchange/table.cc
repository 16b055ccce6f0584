#include "src/exchange/table.h"

#include <utility>

namespace tessera {

std::shared_ptr<const Rebirths> rebirths_between(const Table& older, const Table& newer,
                                                 std::shared_ptr<const Rebirths> earlier) {
  auto made = std::make_shared<Rebirths>();
  made->after = older.epoch;
  made->epoch = newer.epoch;
  for (std::uint32_t t = 0; t < newer.incarnations.size(); ++t) {
    if (newer.peer_of(TileId{t}) != older.peer_of(TileId{t})) made->tiles.push_back(TileId{t});
  }
  made->before = std::move(earlier);
  return made;
}

}  // namespace tessera
