// Knows for which tiles a node has the memory. A plain object.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "src/exchange/assignment.h"
#include "src/exchange/placements.h"

namespace tessera {

class NodeRoom {
 public:
  // Returns the greatest weight of a tile that a node with so many threads and so much memory can work on.
  using WeightMax = std::function<std::uint64_t(std::uint32_t threads, std::uint64_t memory_bytes)>;
  // Describes a tile of this weight and what it needs, for users: "a tile of size 5, which needs about 3 MiB".
  using TileInWords = std::function<std::string(std::uint64_t weight)>;
  // A node as it is named in a sentence.
  struct Named {
    std::string name;
    std::uint64_t memory_bytes = 0;
  };

  // Both functions may be empty: any node has room for any tile; a tile is "one of the tiles".
  NodeRoom(WeightMax weight_max, TileInWords in_words);

  Host host(NodeId node, std::uint32_t threads, std::uint64_t memory_bytes) const;
  // Returns whether the host has room for any of the tiles.
  static bool has_any(const Host& host, const Placements& placements);
  // Returns the tiles for which no host has room.
  static std::vector<TileId> without(std::span<const Host> hosts, const Placements& placements);
  // Says that no node has enough memory for the largest of these tiles, and which of the nodes gives a job most.
  std::string why_none(std::span<const TileId> tiles, const Placements& placements, std::span<const Named> nodes) const;

 private:
  WeightMax weight_max_;
  TileInWords in_words_;
};

}  // namespace tessera
