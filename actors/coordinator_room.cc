// Memory for tiles: a tile goes to a node that has the memory for it. While no node has, the job waits for one.
#include <algorithm>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"

namespace tessera {

Host Coordinator::host(NodeId node, std::uint32_t threads, std::uint64_t memory_bytes) const {
  Host host{node, threads};
  if (options_.weight_max) host.weight_max = options_.weight_max(threads, memory_bytes);
  return host;
}

// Returns whether the job can begin: some node has room for each tile. Used when no node has a share yet.
bool Coordinator::may_begin() {
  std::vector<Host> hosts;
  for (const ShareFound& found : answers_) hosts.push_back(host(NodeId{0}, found.threads, found.memory_bytes));
  std::vector<TileId> without;
  std::copy_if(placements_.order().begin(), placements_.order().end(), std::back_inserter(without),
               [&](TileId tile) { return !any_has_room(hosts, placements_.weight(tile)); });
  if (!without.empty()) wait_for_room(without);
  return without.empty();
}

// Returns whether the node has room for any of the tiles.
bool Coordinator::has_room(NodeId node) const {
  const Host one = host(node, roster_[node].threads, roster_[node].memory_bytes);
  return std::any_of(placements_.order().begin(), placements_.order().end(),
                     [&](TileId tile) { return placements_.weight(tile) <= one.weight_max; });
}

void Coordinator::wait_for_room(const std::vector<TileId>& tiles) {
  if (std::exchange(without_room_, true)) return;
  std::uint64_t largest = 0;
  for (const TileId tile : tiles) largest = std::max(largest, placements_.weight(tile));
  std::string name;
  std::uint64_t most = 0;
  const auto look = [&](const std::string& whose, std::uint64_t bytes) {
    if (bytes < most) return;
    name = whose;
    most = bytes;
  };
  if (course_.is(At::finding)) {  // no node has a share yet
    for (const ShareFound& found : answers_) look(found.name, found.memory_bytes);
  }
  for (const Roster::Node& node : roster_.nodes()) {
    if (node.there()) look(node.name, node.memory_bytes);
  }
  const std::string tile = options_.tile_in_words ? options_.tile_in_words(largest) : "one of the tiles";
  const std::string because = "no node has the memory for " + tile + ": node " + name + " gives a job most, " +
                              std::to_string(most >> 20) + " MiB";
  wait_for_a_node(failure_of(error(Errc::memory, because + "; use smaller tiles, or a node with more memory")),
                  because);
}

}  // namespace tessera
