// A 2D result, or the triangles of a surface, as a tileset of 3D Tiles 1.1 (OGC 22-025r4): a tree of binary glTF files,
// coarse at the root, all triangles at the leaves, for viewers that load what they see.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera {

inline constexpr const char* tileset_format = "3dtiles";  // beside those of src/result/export

struct TilesetOptions {
  std::optional<double> max_edge = {};    // cells with a longer edge in the plane are left out
  std::uint64_t node_triangles = 16'384;  // a leaf has no more, an inner node about as many
  bool overwrite = false;                 // replaces a tileset, nothing else
  // Of a surface's triangles, which face all ways: the partition of the triangulation that they come from.
  std::optional<std::string> surface_of = {};
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  std::function<void(double)> progress = {};  // is told the part that is done, 0..1; or null
};

struct Tileset {
  std::filesystem::path path;
  std::uint64_t nodes = 0, leaves = 0;
  std::uint64_t triangles = 0;  // of the leaves: the main cells that are not left out, each once
  std::uint64_t left_out = 0;   // cells, for their edges
  std::uint64_t bytes = 0;      // of the files of all nodes
};

// What the command prints: one line of JSON without its end.
std::string to_json(const Tileset& tileset);

// Bytes of disk that the tileset of a result takes at most, about.
std::uint64_t tileset_bytes(const Manifest& manifest);

// Makes the folder `target`, with tileset.json and nodes/NNNNNN.glb. Properties:
//  (1) The leaves have each main cell once. Inner nodes are their children joined and made coarser, down to
//      `node_triangles` if their borders allow it.
//  (2) Any cut through the tree is a surface without gaps: the edges along which nodes meet are never changed, so they
//      are the same on all levels, but for the rounding to 1/65,535 of a node's extent.
//  (3) geometricError is in units of the coordinates: the root of the mean square of how far the vertices of the
//      children are, in height, or of a surface in space, added up from the leaves on, whose error is 0.
//  (4) A function of the result's tiles alone: made again it has the same bytes.
// Each tile is read once; in memory are a tile and the coarse surfaces that wait for their neighbours. The folder is
// written under a temporary name and renamed when it is whole; checksums of all files are in tileset.json. Errors:
// usage for wrong options, a 3D result, a random partition, a target that exists; memory when the largest tile does
// not fit; io, also when the disk has too little room; corrupt; interrupted.
Result<Tileset> write_tileset(const std::filesystem::path& out, const std::filesystem::path& target,
                              const TilesetOptions& options, std::stop_token stop);
// What can be said before there is a result. Error usage when something stands there that is not to be replaced, io.
Status check_tileset_target(const std::filesystem::path& target, bool overwrite);
// `partition`: of the result `out`. Error usage when its tiles do not lie side by side, so that they make no tree.
Status check_tileset_partition(const std::filesystem::path& out, const std::string& partition);

}  // namespace tessera
