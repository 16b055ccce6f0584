// Tells the owner of the run how far the job is.
#include <utility>
#include <vector>

#include "actors/coordinator.h"

namespace tessera {

void Coordinator::show_progress(ShareProgress& message) {
  const NodeId node = message.node;
  if (roster_.has(node) && account_.heard(node, std::move(message), parts_.size())) tell_progress();
}

void Coordinator::tell_progress() {
  count_tiles();
  std::vector<Account::Node> nodes;
  for (const Roster::Node& node : roster_.nodes())
    nodes.push_back({node.name, node.tiles, node.gone(), node.standing == Standing::left});
  owner_.progressed(account_.progress(nodes));
}

void Coordinator::count_tiles() {
  if (counted_ == table().epoch) return;
  counted_ = table().epoch;
  const std::vector<std::uint32_t> tiles = placements_.tiles(parts_.size());
  for (std::uint32_t n = 0; n < tiles.size(); ++n) roster_[NodeId{n}].tiles = tiles[n];
}

}  // namespace tessera
