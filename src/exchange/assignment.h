// Which node works on which tile. Pure functions: whoever computes them finds the same.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "src/base/ids.h"
#include "src/exchange/routing_table.h"

namespace tessera {

// A node that takes tiles, for how much of the work it counts: its threads; and how heavy a tile may be that it has
// the memory to work on.
struct Host {
  NodeId node;
  std::uint32_t threads = 1;
  std::uint64_t weight_max = std::numeric_limits<std::uint64_t>::max();
};

// A tile's new home. Of a tile that begins again the incarnation is another one.
struct Placement {
  TileId tile;
  NodeId node;
  Incarnation incarnation;
  friend bool operator==(const Placement&, const Placement&) = default;
};

// Cuts `tiles`, in the order given, into contiguous runs, one a host, by weight and threads. In the order of a
// space-filling curve most neighbours are at home. A tile for which its host has no room goes to whoever has, and has
// least to do. Returns a node for each. REQUIRES: there is a host with room for each.
std::vector<NodeId> share_out(std::span<const TileId> tiles, std::span<const std::uint64_t> weights,
                              std::span<const Host> hosts);

// Whether one of the hosts has room for a tile of this weight.
bool any_has_room(std::span<const Host> hosts, std::uint64_t weight);

// `tiles` begin again as other incarnations, each somewhere on `hosts`. `weights`: by tile, of all. `term`: of the
// coordinator: those of one that does not know yet that it has been replaced are others.
std::vector<Placement> place_again(const RoutingTable& table, std::span<const TileId> tiles,
                                   std::span<const std::uint64_t> weights, std::span<const Host> hosts, Term term = {});

// REQUIRES: the table has these tiles.
RoutingTable next_table(const RoutingTable& table, Epoch epoch, std::span<const Placement> changes);

}  // namespace tessera
