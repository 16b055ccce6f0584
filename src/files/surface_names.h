// What the making of a surface puts down in its scratch folder (src/surface/passes.h), a file a tile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace tessera {

enum class SurfaceScratch : std::uint8_t { tiles, rays, sums, votes, arcs, labels };

inline std::filesystem::path surface_scratch(const std::filesystem::path& scratch, SurfaceScratch what) {
  constexpr const char* names[] = {"tiles", "rays", "sums", "votes", "arcs", "labels"};
  return scratch / names[static_cast<std::size_t>(what)];
}
// Of the tile with this number.
inline std::filesystem::path surface_cells_file(const std::filesystem::path& tiles, std::size_t number) {
  return tiles / (std::to_string(number) + ".cells");
}
inline std::filesystem::path surface_weights_file(const std::filesystem::path& tiles, std::size_t number) {
  return tiles / (std::to_string(number) + ".weights");
}
inline std::filesystem::path surface_mail_file(const std::filesystem::path& mail, std::size_t number) {
  return mail / (std::to_string(number) + ".mail");
}
// A surface's triangles, as a result is stored, until they are written as they are wanted.
inline std::filesystem::path surface_triangles(const std::filesystem::path& scratch) { return scratch / "triangles"; }
inline std::filesystem::path surface_split_triangles(const std::filesystem::path& scratch) { return scratch / "split"; }
inline std::filesystem::path surface_smooth_triangles(const std::filesystem::path& scratch) {
  return scratch / "smooth";
}
// Of smoothing, while it goes on: tiles and mail, as above.
inline std::filesystem::path surface_smoothing(const std::filesystem::path& scratch) { return scratch / "smoothing"; }

}  // namespace tessera
