#include "src/exchange/placements.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tessera {

Placements::Placements(PlacementOptions options, RoutingTable table)
    : options_(std::move(options)), table_(std::move(table)), stored_(options_.weights.size()) {}

std::vector<std::uint64_t> Placements::held(std::size_t nodes) const {
  std::vector<std::uint64_t> held(nodes);
  for (const TileId t : options_.order) {
    if (const NodeId node = table_.node_of(t); node.value < nodes) held[node.value] += weight(t);
  }
  return held;
}

std::vector<std::uint32_t> Placements::tiles(std::size_t nodes) const {
  std::vector<std::uint32_t> tiles(nodes);
  for (const TileId t : options_.order) {
    if (const NodeId node = table_.node_of(t); node.value < nodes) ++tiles[node.value];
  }
  return tiles;
}

// The new epochs and incarnations are of this coordinator's term. So they differ from those of shares that go on though
// no coordinator has asked them.
void Placements::begin(std::uint32_t stage, std::span<const Host> hosts) {
  table_ = {{options_.term, 0},
            stage,
            std::vector<NodeId>(options_.weights.size()),
            std::vector<Incarnation>(options_.weights.size(), Incarnation{options_.term, 0})};
  const std::vector<NodeId> nodes = share_out(options_.order, options_.weights, hosts);
  for (std::size_t i = 0; i < nodes.size(); ++i) table_.nodes[options_.order[i].value] = nodes[i];
}

// Nodes have come and gone, so the work is shared out anew. A tile that stays on its node keeps its incarnation:
// nothing of the stage before is on its way to it.
std::vector<Placement> Placements::begin_next_stage(const std::vector<Host>& hosts, const Lives& lives) {
  if (table_.nodes.empty()) {  // one node had all tiles
    table_.nodes.assign(options_.weights.size(), NodeId{0});
    table_.incarnations.assign(options_.weights.size(), {});
  }
  ++table_.stage;
  stored_.assign(stored_.size(), false);
  late_.clear();
  std::vector<TileId> tiles = options_.order;
  std::vector<Placement> changes = hosts.empty() ? std::vector<Placement>() : again(tiles, hosts, lives);
  std::erase_if(changes, [&](const Placement& change) { return table_.node_of(change.tile) == change.node; });
  // Tiles are left over when no host has room for them, or when all nodes that are there are about to leave.
  std::copy_if(tiles.begin(), tiles.end(), std::back_inserter(released_),
               [&](TileId tile) { return hosts.empty() || !lives(table_.node_of(tile)); });
  return changes;
}

bool Placements::store(TileId tile) {
  if (stored_.at(tile.value)) return false;
  stored_[tile.value] = true;
  return true;
}

std::size_t Placements::lose(NodeId node) {
  asked_.erase(node);
  handing_.erase(node);
  const std::size_t before = lost_.size();
  std::copy_if(options_.order.begin(), options_.order.end(), std::back_inserter(lost_),
               [&](TileId t) { return table_.node_of(t) == node && !stored_[t.value]; });
  return lost_.size() - before;
}

std::size_t Placements::release_homeless(const Lives& lives, const std::vector<bool>& given_up) {
  const std::size_t before = released_.size();
  std::copy_if(options_.order.begin(), options_.order.end(), std::back_inserter(released_), [&](TileId t) {
    const bool lost = !lives(table_.node_of(t)) || (!given_up.empty() && given_up[t.value]);
    return lost && !stored_[t.value];
  });
  return released_.size() - before;
}

bool Placements::take_answer(NodeId node, std::span<const TileId> tiles) {
  const auto asked = asked_.find(node);
  if (asked == asked_.end()) return false;  // the node was lost meanwhile, and its tiles with it
  asked_.erase(asked);
  release(tiles);
  return true;
}

std::vector<Placements::Request> Placements::ask_for(NodeId newcomer, std::span<const Host> hosts) {
  std::size_t nodes = 0;
  for (const Host& host : hosts) nodes = std::max<std::size_t>(nodes, host.node.value + 1);
  const std::vector<std::uint64_t> held = this->held(nodes);
  std::vector<Request> requests;
  for (const Host& host : hosts) {
    if (host.node == newcomer) continue;
    ask(host.node);
    requests.push_back({host.node, held[host.node.value] / hosts.size()});
  }
  return requests;
}

bool Placements::end_handing(NodeId node) {
  if (handing_.erase(node) == 0) return false;
  std::vector<bool> moves(options_.weights.size());
  for (const TileId t : released_) moves[t.value] = true;
  std::copy_if(options_.order.begin(), options_.order.end(), std::back_inserter(released_),
               [&](TileId t) { return table_.node_of(t) == node && !stored_[t.value] && !moves[t.value]; });
  return true;
}

// Places those of `tiles` for which some host has room, and removes them from `tiles`. With `all`, `hosts` are all
// hosts that there are. Then a tile without room anywhere does not wait when the table has it on a node that lives: its
// node has given it up before it began, and goes on without it. Such a tile goes to the host with most room.
std::vector<Placement> Placements::again(std::vector<TileId>& tiles, std::vector<Host> hosts, const Lives& lives,
                                         bool all) const {
  const auto waits = std::stable_partition(tiles.begin(), tiles.end(), [&](TileId tile) {
    return any_has_room(hosts, weight(tile)) || (all && lives(table_.node_of(tile)));
  });
  const std::vector<TileId> placed(tiles.begin(), waits);
  tiles.erase(tiles.begin(), waits);
  if (placed.empty()) return {};
  const auto roomiest = std::max_element(hosts.begin(), hosts.end(),
                                         [](const Host& a, const Host& b) { return a.weight_max < b.weight_max; });
  for (const TileId tile : placed) roomiest->weight_max = std::max(roomiest->weight_max, weight(tile));
  return place_again(table_, placed, options_.weights, hosts, options_.term);
}

Placements::Placed Placements::place(const std::vector<Host>& hosts, const Lives& lives) {
  std::vector<Host> late;
  std::copy_if(hosts.begin(), hosts.end(), std::back_inserter(late),
               [&](const Host& host) { return std::find(late_.begin(), late_.end(), host.node) != late_.end(); });
  late_.clear();
  Placed placed{again(lost_, hosts, lives), 0};
  placed.again = placed.changes.size();
  for (const bool all : {false, true}) {  // first to nodes that came late, then the rest to all
    const auto moved = again(released_, all ? hosts : late, lives, all);
    placed.changes.insert(placed.changes.end(), moved.begin(), moved.end());
  }
  return placed;
}

const RoutingTable& Placements::change(std::span<const Placement> changes) {
  table_ = next_table(table_, table_.epoch.next(options_.term), changes);
  return table_;
}

}  // namespace tessera
