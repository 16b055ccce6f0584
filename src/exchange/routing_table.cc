#include "src/exchange/routing_table.h"

#include <utility>

namespace tessera {

std::shared_ptr<const IncarnationChanges> incarnation_changes_between(
    const RoutingTable& older, const RoutingTable& newer, std::shared_ptr<const IncarnationChanges> earlier) {
  auto made = std::make_shared<IncarnationChanges>();
  made->after = older.epoch;
  made->epoch = newer.epoch;
  for (std::uint32_t t = 0; t < newer.incarnations.size(); ++t) {
    if (newer.peer_of(TileId{t}) != older.peer_of(TileId{t})) made->tiles.push_back(TileId{t});
  }
  made->before = std::move(earlier);
  return made;
}

}  // namespace tessera
