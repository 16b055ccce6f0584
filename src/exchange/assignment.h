// Decides which node works on which tile. These are pure functions: every process computes the same answer.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "src/base/ids.h"
#include "src/exchange/routing_table.h"

namespace tessera {

// A node to which tiles can be given. `threads` is its share of the work. `weight_max` is the weight of the heaviest
// tile for which the node has enough memory.
struct Host {
  NodeId node;
  std::uint32_t threads = 1;
  std::uint64_t weight_max = std::numeric_limits<std::uint64_t>::max();
};

// A tile's new node. A tile that begins again gets another incarnation.
struct Placement {
  TileId tile;
  NodeId node;
  Incarnation incarnation;
  friend bool operator==(const Placement&, const Placement&) = default;
};

// Cuts `tiles`, in the order given, into one contiguous run for each host, in proportion to the hosts' threads. When
// the tiles are in the order of a space-filling curve, most neighbours of a tile are on the same host. A tile that is
// too heavy for its host goes to the host that has room for it and has the least to do. Returns the node of each tile,
// in the order of `tiles`. `weights` has an entry for every tile of the job, by tile id. REQUIRES: some host has room
// for each tile.
std::vector<NodeId> share_out(std::span<const TileId> tiles, std::span<const std::uint64_t> weights,
                              std::span<const Host> hosts);

// Returns whether one of the hosts has room for a tile of this weight.
bool any_has_room(std::span<const Host> hosts, std::uint64_t weight);

// Places `tiles` on `hosts`, as share_out() does, each as its next incarnation. `weights` has an entry for every tile
// of the job, by tile id. `term` is the coordinator's term. The new incarnations belong to that term, so those of a
// replaced coordinator are never equal to them.
std::vector<Placement> place_again(const RoutingTable& table, std::span<const TileId> tiles,
                                   std::span<const std::uint64_t> weights, std::span<const Host> hosts, Term term = {});

// Returns `table` with `changes` made, as the table of `epoch`. REQUIRES: the table has an entry for each of these
// tiles.
RoutingTable next_table(const RoutingTable& table, Epoch epoch, std::span<const Placement> changes);

}  // namespace tessera
