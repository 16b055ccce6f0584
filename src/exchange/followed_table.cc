#include "src/exchange/followed_table.h"

#include <algorithm>

namespace tessera {

bool is_table_of_job(const RoutingTable& table, std::size_t tiles, std::size_t stages, std::size_t nodes) {
  return table.nodes.size() == tiles && table.incarnations.size() == tiles && table.stage < stages &&
         std::all_of(table.nodes.begin(), table.nodes.end(), [&](NodeId node) { return node.value < nodes; });
}

std::vector<std::uint64_t> weights_on(NodeId node, const RoutingTable& table, std::vector<std::uint64_t> weights) {
  for (std::uint32_t t = 0; t < weights.size(); ++t) {
    if (table.node_of(TileId{t}) != node) weights[t] = 0;
  }
  return weights;
}

}  // namespace tessera
