// A result as a file other programs read: main cells only, every vertex once, streamed tile by tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

#include "src/base/result.h"

namespace tessera {

enum class ExportFormat : std::uint8_t {
  ply,      // binary little endian; faces in 2D, element "cell" of 4 vertices in 3D
  vtu,      // VTK XML, raw appended; a folder gets one .vtu a tile and a .pvtu over them
  off,      // text; 3D: each tetrahedron as its vertex list
  geojson,  // 2D only: a FeatureCollection of triangles
};

// "ply", "vtu", "off" or "geojson"; error usage otherwise.
Result<ExportFormat> parse_export_format(const std::string& name);

struct Exported {
  std::uint64_t vertices = 0, cells = 0;
  std::uint64_t bytes = 0;  // written, all files together
};

// Writes the result folder `out` to `target`: a file, or, for vtu, also a folder (one that exists, or a path without
// the ending .vtu). Written under a temporary name and renamed; memory is that of the largest tile plus 12 bytes a
// vertex. Errors: usage for a format that cannot hold the result, corrupt for a damaged tile, io, interrupted.
Result<Exported> export_result(const std::filesystem::path& out, ExportFormat format,
                               const std::filesystem::path& target, std::stop_token stop);

}  // namespace tessera
