// Says which node has which tile, and which incarnation of the tile is alive. The coordinator makes a table of the next
// epoch whenever tiles move. When a node is lost, its tiles are reborn on other nodes, each as its next incarnation.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/ids.h"
#include "src/exchange/counters.h"

namespace tessera {

struct RoutingTable {
  Epoch epoch;
  std::uint32_t stage = 0;  // number of the stage; an epoch belongs to one stage
  // Both by tile. When they are empty, all tiles are on node 0, in their first life.
  std::vector<NodeId> nodes;
  std::vector<Incarnation> incarnations;

  NodeId node_of(TileId tile) const { return nodes.empty() ? NodeId{0} : nodes[tile.value]; }
  // Returns the tile's living incarnation.
  TileIncarnation peer_of(TileId tile) const {
    return {tile, incarnations.empty() ? Incarnation() : incarnations[tile.value]};
  }
  bool alive(TileIncarnation peer) const { return peer == peer_of(peer.tile); }
  // Returns whether the peer is known to be dead. An incarnation younger than that of the table is neither alive nor
  // dead: a later table tells of it.
  bool dead(TileIncarnation peer) const { return peer.incarnation < peer_of(peer.tile).incarnation; }

  friend bool operator==(const RoutingTable&, const RoutingTable&) = default;
};

// The tiles to which a table has given another incarnation than the table before it, and a link to the changes of that
// table. So a tile or share that gets a table finds the tiles that were reborn since its own table without looking at
// all tiles.
struct IncarnationChanges {
  Epoch after, epoch;  // the epochs of the table before, and of the table
  std::vector<TileId> tiles;
  std::shared_ptr<const IncarnationChanges> before;  // null: no tile goes by an older table
};
// REQUIRES: both tables are of one job, and `older` is the older one; `earlier` ends with `older`, or is null.
std::shared_ptr<const IncarnationChanges> incarnation_changes_between(
    const RoutingTable& older, const RoutingTable& newer, std::shared_ptr<const IncarnationChanges> earlier);

}  // namespace tessera
