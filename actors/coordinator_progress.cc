// What the owner of a job is told of its way.
#include <utility>
#include <vector>

#include "actors/coordinator.h"

namespace tessera {

void Coordinator::show_progress(PartProgress& message) {
  const NodeId node = message.node;
  if (has(node) && account_.heard(node, std::move(message), parts_.size())) tell_progress();
}

void Coordinator::tell_progress() {
  count_tiles();
  std::vector<Account::Node> nodes;
  for (const PartOf& p : parts_) nodes.push_back({p.name, p.tiles, p.lost, p.left});
  owner_.progressed(account_.progress(nodes));
}

void Coordinator::count_tiles() {
  if (counted_ == table_.epoch) return;
  counted_ = table_.epoch;
  for (PartOf& p : parts_) p.tiles = 0;
  for (const TileId t : options_.order) {
    if (const NodeId node = table_.node_of(t); node.value < parts_.size()) ++parts_[node.value].tiles;
  }
}

}  // namespace tessera
