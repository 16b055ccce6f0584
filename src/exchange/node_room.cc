#include "src/exchange/node_room.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tessera {

NodeRoom::NodeRoom(WeightMax weight_max, TileInWords in_words)
    : weight_max_(std::move(weight_max)), in_words_(std::move(in_words)) {}

Host NodeRoom::host(NodeId node, std::uint32_t threads, std::uint64_t memory_bytes) const {
  Host host{node, threads};
  if (weight_max_) host.weight_max = weight_max_(threads, memory_bytes);
  return host;
}

bool NodeRoom::has_any(const Host& host, const Placements& placements) {
  return std::any_of(placements.order().begin(), placements.order().end(),
                     [&](TileId tile) { return placements.weight(tile) <= host.weight_max; });
}

std::vector<TileId> NodeRoom::without(std::span<const Host> hosts, const Placements& placements) {
  std::vector<TileId> without;
  std::copy_if(placements.order().begin(), placements.order().end(), std::back_inserter(without),
               [&](TileId tile) { return !any_has_room(hosts, placements.weight(tile)); });
  return without;
}

std::string NodeRoom::why_none(std::span<const TileId> tiles, const Placements& placements,
                               std::span<const Named> nodes) const {
  std::uint64_t largest = 0;
  for (const TileId tile : tiles) largest = std::max(largest, placements.weight(tile));
  std::string name;
  std::uint64_t most = 0;
  for (const Named& node : nodes) {
    if (node.memory_bytes < most) continue;
    name = node.name;
    most = node.memory_bytes;
  }
  const std::string tile = in_words_ ? in_words_(largest) : "one of the tiles";
  return "no node has enough memory for " + tile + ": the most that a job gets is " + std::to_string(most >> 20) +
         " MiB, on node " + name;
}

}  // namespace tessera
