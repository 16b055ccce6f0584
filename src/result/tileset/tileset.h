// Writes a 2D result, or the triangles of a surface, as a tileset of 3D Tiles 1.1 (OGC 22-025r4): a tree of binary glTF
// files, coarse at the root and with all triangles at the leaves, for viewers that load what they show.
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

inline constexpr const char* tileset_format = "3dtiles";  // in addition to the formats of src/result/export

struct TilesetOptions {
  std::optional<double> max_edge = {};    // cells with a longer edge in the plane are left out
  std::optional<double> max_radius = {};  // and cells with a larger circumradius
  std::uint64_t node_triangles = 16'384;  // a leaf has at most as many; an inner node about as many
  bool overwrite = false;                 // replaces an existing tileset, and nothing else
  // Set for the triangles of a surface, which face all ways: the partition of the triangulation from which they come.
  std::optional<std::string> surface_of = {};
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  std::function<void(double)> progress = {};  // called with the fraction that is done, 0..1; may be null
};

struct Tileset {
  std::filesystem::path path;
  std::uint64_t nodes = 0, leaves = 0;
  std::uint64_t triangles = 0;  // of the leaves: each main cell that is not left out, once
  std::uint64_t left_out = 0;   // cells left out because of their edges
  std::uint64_t bytes = 0;      // of the files of all nodes
};

// One line of JSON, without its end, for the command's output.
std::string to_json(const Tileset& tileset);

// About the most bytes of disk that the tileset of a result takes.
std::uint64_t tileset_bytes(const Manifest& manifest);

// Makes the folder `target`, with tileset.json and nodes/NNNNNN.glb. Properties:
//  (1) The leaves have each main cell once. An inner node has its children's surfaces, joined and simplified to
//      `node_triangles` triangles, if their borders allow it.
//  (2) Any cut through the tree is a surface without gaps. The edges at which nodes meet never change, so they are the
//      same on all levels, up to rounding to 1/65,535 of a node's extent.
//  (3) geometricError is in units of the coordinates: the root of the mean square of the vertices' distances from the
//      simplified surface, in height, or in space for a surface. It adds up from the leaves, whose error is 0.
//  (4) The files depend only on the result's tiles: made again, they have the same bytes.
//
// Each tile is read once. Memory holds one tile, and the coarse surfaces that wait for their neighbours. The folder is
// written under a temporary name and renamed when it is complete; tileset.json has the checksums of all files. Errors:
// usage for wrong options, a 3D result, a random partition or an existing target; memory when the largest tile does not
// fit; io, also when the disk has too little room; corrupt; interrupted.
Result<Tileset> write_tileset(const std::filesystem::path& out, const std::filesystem::path& target,
                              const TilesetOptions& options, std::stop_token stop);
// Checks the target before there is a result. Errors: usage when something exists there that may not be replaced; io.
Status check_tileset_target(const std::filesystem::path& target, bool overwrite);
// `partition` is that of the result `out`. Error usage when the tiles do not lie side by side, so that they form no
// tree.
Status check_tileset_partition(const std::filesystem::path& out, const std::string& partition);

}  // namespace tessera
