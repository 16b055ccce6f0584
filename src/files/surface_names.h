// What the making of a surface puts down in its scratch folder (src/surface/passes.h), a file a tile.
#pragma once

#include <cstdint>
#include <filesystem>

namespace tessera {

enum class SurfaceScratch : std::uint8_t { tiles, rays, sums, votes, arcs, labels };

inline std::filesystem::path surface_scratch(const std::filesystem::path& scratch, SurfaceScratch what) {
  constexpr const char* names[] = {"tiles", "rays", "sums", "votes", "arcs", "labels"};
  return scratch / names[static_cast<std::size_t>(what)];
}
// A surface's triangles, as a result is stored, until they are written as they are wanted.
inline std::filesystem::path surface_triangles(const std::filesystem::path& scratch) { return scratch / "triangles"; }

}  // namespace tessera
