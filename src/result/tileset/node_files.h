// Writes the files of a tileset's nodes, and the document that lists them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/result/tileset/surface.h"

namespace tessera::tileset {

struct TilesetNode {
  Bounds bounds;
  double error = 0;  // in units of the coordinates
  std::uint64_t triangles = 0, bytes = 0, xxh3 = 0;
  std::vector<std::size_t> children;  // indices of nodes; empty for a leaf
};

// What viewers need to know of the values before they have loaded all nodes.
struct Ranges {
  std::uint16_t intensity = 0;  // the highest
  std::vector<bool> classes = std::vector<bool>(256);
};

class NodeFiles {
 public:
  // Writes below `folder`, which must exist. `bounds` has the bounds of all points in the plane.
  static Result<NodeFiles> create(const std::filesystem::path& folder, const Bounds& bounds);

  // Writes a node's file. Returns the node's index. Error io.
  Result<std::size_t> add(const Surface& surface, double error, std::vector<std::size_t> children);
  // Writes the document. Error io.
  Status finish(std::size_t root, const Manifest& manifest) const;

  const std::vector<TilesetNode>& nodes() const { return nodes_; }
  std::uint64_t bytes() const { return bytes_; }

 private:
  NodeFiles(std::filesystem::path folder, const Point& origin) : folder_(std::move(folder)), origin_(origin) {}

  std::filesystem::path folder_;
  Point origin_;
  std::vector<TilesetNode> nodes_;
  Ranges ranges_;
  std::uint64_t bytes_ = 0;
};

}  // namespace tessera::tileset
