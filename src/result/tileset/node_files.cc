#include "src/result/tileset/node_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/result/tileset/glb.h"

namespace tessera::tileset {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// A box of 3D Tiles: its centre, and half its sides as vectors.
Json box_of(const Bounds& bounds, const Point& origin) {
  Json box = Json::array();
  for (int axis = 0; axis < 3; ++axis)
    box.push_back(bounds.lo[axis] - origin[axis] + (bounds.hi[axis] - bounds.lo[axis]) / 2);
  for (int side = 0; side < 3; ++side)
    for (int axis = 0; axis < 3; ++axis) box.push_back(side == axis ? (bounds.hi[axis] - bounds.lo[axis]) / 2 : 0);
  return box;
}

Json tile_of(const std::vector<TilesetNode>& nodes, std::size_t place, const Point& origin) {
  const TilesetNode& node = nodes[place];
  Json tile{{"boundingVolume", {{"box", box_of(node.bounds, origin)}}},
            {"geometricError", node.error},
            {"refine", "REPLACE"},
            {"content",
             {{"uri", tileset_node_file("", static_cast<std::uint32_t>(place)).generic_string()},
              {"extras", {{"triangles", node.triangles}, {"bytes", node.bytes}, {"xxh3", checksum_text(node.xxh3)}}}}}};
  for (const std::size_t child : node.children) tile["children"].push_back(tile_of(nodes, child, origin));
  return tile;
}

}  // namespace

Result<NodeFiles> NodeFiles::create(const fs::path& folder, const Bounds& bounds) {
  BOOST_OUTCOME_TRYV(make_directories(tileset_nodes_folder(folder)));
  // An integer, so that relative coordinates are as exact as absolute ones.
  Point origin;
  for (int axis = 0; axis < 2; ++axis) origin[axis] = std::round(bounds.lo[axis] / 2 + bounds.hi[axis] / 2);
  return NodeFiles(folder, origin);
}

Result<std::size_t> NodeFiles::add(const Surface& surface, double error, std::vector<std::size_t> children) {
  const std::size_t place = nodes_.size();
  const std::vector<std::byte> file = to_glb(surface, origin_);
  BOOST_OUTCOME_TRYV(write_whole(tileset_node_file(folder_, static_cast<std::uint32_t>(place)), file));
  for (const SurfaceVertex& v : surface.vertices) {
    ranges_.intensity = std::max(ranges_.intensity, v.intensity);
    ranges_.classes[v.classification] = true;
  }
  nodes_.push_back({surface.bounds(), error, surface.triangles(), file.size(), checksum(file), std::move(children)});
  bytes_ += file.size();
  return place;
}

Status NodeFiles::finish(std::size_t root, const Manifest& manifest) const {
  Json tile = tile_of(nodes_, root, origin_);
  tile["transform"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, origin_.x, origin_.y, origin_.z, 1};
  Json classes = Json::array();
  for (std::size_t i = 0; i < ranges_.classes.size(); ++i)
    if (ranges_.classes[i]) classes.push_back(i);
  Json attributes = Json::array();
  for (const auto& attribute : manifest.schema) attributes.push_back(attribute.name);
  const Bounds& bounds = nodes_[root].bounds;
  const Json document{
      {"asset", {{"version", "1.1"}}},
      // The error when nothing is shown.
      {"geometricError", std::hypot(bounds.hi.x - bounds.lo.x, bounds.hi.y - bounds.lo.y, bounds.hi.z - bounds.lo.z)},
      {"root", std::move(tile)},
      {"extras",
       {{"crs", manifest.crs},
        {"vertices", manifest.vertices},
        {"cells", manifest.cells},
        {"tiles", manifest.tiles.size()},
        {"heights", {bounds.lo.z, bounds.hi.z}},
        {"intensityMax", ranges_.intensity},
        {"classes", std::move(classes)},
        {"attributes", std::move(attributes)}}}};
  return write_whole(tileset_file(folder_), json_text(document) + "\n");
}

}  // namespace tessera::tileset
