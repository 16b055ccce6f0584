// Who hosts which tile, and in which of its lives. The coordinator makes a table of the next epoch whenever a node is
// lost: the tiles that it hosted are reborn, each as the next incarnation, on nodes that live.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/ids.h"
#include "src/exchange/counters.h"

namespace tessera {

struct RoutingTable {
  Epoch epoch;
  std::uint32_t stage = 0;  // of the job; an epoch is of one stage
  // By tile. Empty: all on node 0, all in their first life.
  std::vector<NodeId> nodes;
  std::vector<Incarnation> incarnations;

  NodeId node_of(TileId tile) const { return nodes.empty() ? NodeId{0} : nodes[tile.value]; }
  // The tile's living incarnation.
  TileIncarnation peer_of(TileId tile) const {
    return {tile, incarnations.empty() ? Incarnation() : incarnations[tile.value]};
  }
  bool alive(TileIncarnation peer) const { return peer == peer_of(peer.tile); }
  // Known to have died. A younger one than the table's is neither alive nor dead: a later table tells of it.
  bool dead(TileIncarnation peer) const { return peer.incarnation < peer_of(peer.tile).incarnation; }

  friend bool operator==(const RoutingTable&, const RoutingTable&) = default;
};

// Which tiles a table has given another incarnation than the one before it, and what that one had done: whoever hears
// of a table finds who was reborn since his own, without looking at all tiles.
struct IncarnationChanges {
  Epoch after, epoch;  // of the one before, of the table
  std::vector<TileId> tiles;
  std::shared_ptr<const IncarnationChanges> before;  // null: nobody goes by an older one
};
// REQUIRES: tables of one job, the older first; `earlier` ends with the older one, or is null.
std::shared_ptr<const IncarnationChanges> incarnation_changes_between(
    const RoutingTable& older, const RoutingTable& newer, std::shared_ptr<const IncarnationChanges> earlier);

}  // namespace tessera
