// What a tile alone knows of a watershed: where its own vertices flow to, as far as the tile sees, and the saddles
// between what flows to different places.
//
// A tile has all cells around its own vertices, so it knows the lowest neighbour of each of them. A chain of lowest
// neighbours ends at a root: at a core, which has no lower neighbour, or at a vertex of another tile, where it leaves
// the tile. Images of one point are one vertex here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/measure/order_free_sum.h"
#include "src/result/tile_source.h"
#include "src/result/voids/densities.h"
#include "src/result/voids/level.h"

namespace tessera::voids {

// The number of a vertex in a tile: own vertices in the order of the file, then foreign ones by source index.
using Node = std::uint32_t;
inline constexpr Node no_node = std::numeric_limits<Node>::max();

// The own vertices that flow to one root.
struct Basin {
  Node root = no_node;
  std::uint64_t points = 0;
  OrderFreeSum volume;
};

// The lowest saddle between two roots. A root that is foreign stands for everything that flows there. A foreign vertex
// next to an own one is a root, too, although only its tile knows where it flows to.
struct TileSaddle {
  Node a = no_node, b = no_node;  // a < b
  Level level;
};

struct TileFlow {
  std::size_t own = 0;
  std::vector<Node> nodes;               // by vertex in the file: its number
  std::vector<std::uint8_t> is_foreign;  // by vertex in the file: 1 also for images of own points
  std::vector<PointId> ids;              // by node
  std::vector<double> levels;            // by node: Level::value, NaN outside of all zones
  std::vector<TileId> owners;            // of the foreign nodes
  std::vector<Node> roots;               // of own nodes; no_node outside of all zones
  std::vector<Basin> basins;             // by root
  std::vector<TileSaddle> saddles;

  bool is_core(Node node) const { return node < own && roots[node] == node; }

  // Errors: corrupt when the tile's images of a point contradict each other; interrupted.
  static Result<TileFlow> of(const TileSource& source, std::size_t index, const TileMesh& mesh,
                             const TileDensities& densities, const std::stop_token& stop);
  // Errors: io.
  Status write(const std::filesystem::path& path) const;
  static Result<TileFlow> read(const std::filesystem::path& path);
};

}  // namespace tessera::voids
