// Names of what the making of a surface writes to disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace tessera {

// The folder in which the surface for `target` is made.
inline std::filesystem::path surface_run_folder(std::filesystem::path target) {
  if (!target.has_filename()) target = target.parent_path();  // "mesh/"
  return target += ".surface";
}
// What the steps keep (src/surface/step.h), one file a tile. `number` is that of the kind.
inline std::filesystem::path surface_kept_folder(const std::filesystem::path& run, std::uint32_t number) {
  return run / "kept" / std::to_string(number);
}
inline std::filesystem::path surface_kept_file(const std::filesystem::path& kept, std::uint32_t tile) {
  return kept / (std::to_string(tile) + ".bin");
}

// Tiles that a node does not have in memory.
inline std::filesystem::path surface_tiles_folder(const std::filesystem::path& own) { return own / "cells"; }
// The file of the tile with this number.
inline std::filesystem::path surface_cells_file(const std::filesystem::path& tiles, std::size_t number) {
  return tiles / (std::to_string(number) + ".cells");
}
inline std::filesystem::path surface_mail_folder(const std::filesystem::path& scratch, unsigned turn) {
  return scratch / ("mail-" + std::to_string(turn));
}
inline std::filesystem::path surface_mail_file(const std::filesystem::path& mail, std::size_t number) {
  return mail / (std::to_string(number) + ".mail");
}
// A surface's triangles, stored like a result, until they are written in the form that was asked for.
inline std::filesystem::path surface_triangles(const std::filesystem::path& scratch) { return scratch / "triangles"; }
inline std::filesystem::path surface_split_triangles(const std::filesystem::path& scratch) { return scratch / "split"; }
inline std::filesystem::path surface_smooth_triangles(const std::filesystem::path& scratch) {
  return scratch / "smooth";
}
// For smoothing: tiles as above, and the mail of two turns.
inline std::filesystem::path surface_smoothing(const std::filesystem::path& scratch) { return scratch / "smoothing"; }

}  // namespace tessera
