// Writes a surface as small binary glTF 2.0: quantised and compressed (KHR_mesh_quantization, EXT_meshopt_compression).
#pragma once

#include <cstddef>
#include <vector>

#include "src/result/tileset/surface.h"

namespace tessera::tileset {

// Coordinates are relative to `origin`, in 65,535 steps over the surface's extent on each axis, in glTF's axes x, z,
// -y. The node has offset and step as doubles. Vertices have _INTENSITY, _CLASSIFICATION and _TILE. REQUIRES: the
// surface has triangles.
std::vector<std::byte> to_glb(const Surface& surface, const Point& origin);

}  // namespace tessera::tileset
