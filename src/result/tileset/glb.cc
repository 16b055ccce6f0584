#include "src/result/tileset/glb.h"

#include <meshoptimizer.h>

#include "src/result/tileset/glb_file.h"

namespace tessera::tileset {
namespace {

// Orders triangles and vertices as the triangles need them, which packs well.
Surface in_reading_order(const Surface& surface) {
  Surface ordered{{}, std::vector<std::uint32_t>(surface.corners.size())};
  const std::size_t n = surface.vertices.size();
  meshopt_optimizeVertexCache(ordered.corners.data(), surface.corners.data(), surface.corners.size(), n);
  std::vector<std::uint32_t> to(n);
  meshopt_optimizeVertexFetchRemap(to.data(), ordered.corners.data(), ordered.corners.size(), n);
  ordered.vertices.resize(n);
  for (std::size_t i = 0; i < n; ++i) ordered.vertices[to[i]] = surface.vertices[i];
  for (std::uint32_t& corner : ordered.corners) corner = to[corner];
  return ordered;
}

}  // namespace

std::vector<std::byte> to_glb(const Surface& surface, const Point& origin) {
  const Surface ordered = in_reading_order(surface);
  std::vector<Point> positions;
  std::vector<PackedShort> intensities;
  std::vector<PackedByte> classes;
  std::vector<float> tiles;
  for (const SurfaceVertex& v : ordered.vertices) {
    positions.push_back(v.at);
    intensities.push_back({v.intensity});
    classes.push_back({v.classification});
    tiles.push_back(static_cast<float>(v.tile.value));  // integers below 2^24
  }
  GlbFile file;
  file.add_positions(positions, origin);
  file.add_shorts("_INTENSITY", intensities);
  file.add_bytes("_CLASSIFICATION", classes);
  file.add_floats("_TILE", tiles);
  file.add_triangles(ordered.corners, ordered.vertices.size());
  return file.finish(nullptr);
}

}  // namespace tessera::tileset
