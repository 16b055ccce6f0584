#include "src/exchange/assignment.h"

#include <algorithm>

#include "src/base/check.h"

namespace tessera {
namespace {

// Returns the index of the host with the least load for each of its threads, of those with room for a tile of this
// weight.
std::size_t least_loaded(std::span<const Host> hosts, const std::vector<double>& load, std::uint64_t weight) {
  std::size_t least = hosts.size();
  for (std::size_t h = 0; h < hosts.size(); ++h) {
    if (weight > hosts[h].weight_max) continue;
    if (least == hosts.size() || load[h] / hosts[h].threads < load[least] / hosts[least].threads) least = h;
  }
  check(least < hosts.size(), "somebody has room for the tile");
  return least;
}

}  // namespace

std::vector<NodeId> share_out(std::span<const TileId> tiles, std::span<const std::uint64_t> weights,
                              std::span<const Host> hosts) {
  check(!hosts.empty(), "somebody takes the tiles");
  double all_weight = 0, all_threads = 0;
  for (const TileId t : tiles) all_weight += static_cast<double>(weights[t.value]);
  for (const Host& host : hosts) all_threads += host.threads;
  std::vector<std::size_t> homes;
  homes.reserve(tiles.size());
  std::vector<double> load(hosts.size());
  std::size_t host = 0;
  double begun = 0, until = all_weight * hosts[0].threads / all_threads;
  for (const TileId t : tiles) {
    const auto own = static_cast<double>(weights[t.value]);
    // A tile belongs to the host in whose interval the tile's middle lies.
    while (host + 1 < hosts.size() && begun + own / 2 > until) {
      ++host;
      until += all_weight * hosts[host].threads / all_threads;
    }
    begun += own;
    homes.push_back(host);
    if (weights[t.value] <= hosts[host].weight_max) load[host] += own;
  }
  std::vector<NodeId> nodes;
  nodes.reserve(tiles.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const std::uint64_t own = weights[tiles[i].value];
    if (own > hosts[homes[i]].weight_max) {
      homes[i] = least_loaded(hosts, load, own);
      load[homes[i]] += static_cast<double>(own);
    }
    nodes.push_back(hosts[homes[i]].node);
  }
  return nodes;
}

bool any_has_room(std::span<const Host> hosts, std::uint64_t weight) {
  return std::any_of(hosts.begin(), hosts.end(), [&](const Host& host) { return weight <= host.weight_max; });
}

std::vector<Placement> place_again(const RoutingTable& table, std::span<const TileId> tiles,
                                   std::span<const std::uint64_t> weights, std::span<const Host> hosts, Term term) {
  const std::vector<NodeId> nodes = share_out(tiles, weights, hosts);
  std::vector<Placement> placements;
  placements.reserve(tiles.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    placements.push_back({tiles[i], nodes[i], table.peer_of(tiles[i]).incarnation.next(term)});
  }
  return placements;
}

RoutingTable next_table(const RoutingTable& table, Epoch epoch, std::span<const Placement> changes) {
  RoutingTable next = table;
  next.epoch = epoch;
  for (const Placement& change : changes) {
    next.nodes.at(change.tile.value) = change.node;
    next.incarnations.at(change.tile.value) = change.incarnation;
  }
  return next;
}

}  // namespace tessera
