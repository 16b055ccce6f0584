// Tiles go where there is the memory for them; while no node has it, a job waits for one.
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

// One that nobody has begun, and that its node has given up, is nobody's until the table says otherwise, and the table
// has it on a node that lives: it does not wait, and goes to whoever has most room.
std::vector<Placement> Coordinator::again(std::vector<TileId>& tiles, std::vector<Host> hosts, bool all) const {
  const auto waits = std::stable_partition(tiles.begin(), tiles.end(), [&](TileId tile) {
    return any_has_room(hosts, options_.weights[tile.value]) || (all && !parts_[table_.node_of(tile).value].lost);
  });
  const std::vector<TileId> placed(tiles.begin(), waits);
  tiles.erase(tiles.begin(), waits);
  if (placed.empty()) return {};
  const auto roomiest = std::max_element(hosts.begin(), hosts.end(),
                                         [](const Host& a, const Host& b) { return a.weight_max < b.weight_max; });
  for (const TileId tile : placed) roomiest->weight_max = std::max(roomiest->weight_max, options_.weights[tile.value]);
  return place_again(table_, placed, options_.weights, hosts, first_incarnation());
}

// When nobody has a part yet.
bool Coordinator::may_begin() {
  std::vector<Host> hosts;
  for (const PartFound& found : answers_) hosts.push_back(host(NodeId{0}, found.threads, found.memory_bytes));
  std::vector<TileId> without;
  std::copy_if(options_.order.begin(), options_.order.end(), std::back_inserter(without),
               [&](TileId tile) { return !any_has_room(hosts, options_.weights[tile.value]); });
  if (!without.empty()) wait_for_room(without, answers_);
  return without.empty();
}

// For any tile.
bool Coordinator::has_room(NodeId node) const {
  const PartOf& p = parts_[node.value];
  const Host one = host(node, p.threads, p.memory_bytes);
  return std::any_of(options_.order.begin(), options_.order.end(),
                     [&](TileId tile) { return options_.weights[tile.value] <= one.weight_max; });
}

// `nodes`: that there are, when none has a part yet.
void Coordinator::wait_for_room(const std::vector<TileId>& tiles, const std::vector<PartFound>& nodes) {
  if (std::exchange(without_room_, true)) return;
  std::uint64_t largest = 0;
  for (const TileId tile : tiles) largest = std::max(largest, options_.weights[tile.value]);
  std::string name;
  std::uint64_t most = 0;
  const auto look = [&](const std::string& whose, std::uint64_t bytes) {
    if (bytes < most) return;
    name = whose;
    most = bytes;
  };
  for (const PartFound& found : nodes) look(found.name, found.memory_bytes);
  for (const PartOf& p : parts_) {
    if (p.there()) look(p.name, p.memory_bytes);
  }
  const std::string tile = options_.tile_in_words ? options_.tile_in_words(largest) : "one of the tiles";
  const std::string because = "no node has the memory for " + tile + ": node " + name + " gives a job most, " +
                              std::to_string(most >> 20) + " MiB";
  wait_for_a_node(failure_of(error(Errc::memory, because + "; use smaller tiles, or a node with more memory")),
                  because);
}

}  // namespace tessera
