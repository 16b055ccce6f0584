// The one table of the formats: what --help lists, what is refused, and who writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "src/result/export/mesh_writer.h"

namespace tessera::exports {

enum class Shape : std::uint8_t {
  file,    // one file for all tiles, or a folder with one a tile
  folder,  // a folder of arrays for all tiles
};

struct Format {
  const char* name;          // --format
  const char* ending;        // of the files
  const char* ending2 = "";  // that means the same when it stands in --output
  const char* summary;       // for --help
  bool in_3d = true;         // 2D all of them hold
  Shape shape = Shape::file;
  bool corners = false;         // cells carry coordinates and rows; there is no list of vertices
  bool vertex_layer = false;    // but one of those with attributes, if there are any
  bool crs = false;             // tells the coordinate system
  bool attributes = false;      // holds those of the vertices
  bool heights_apart = false;   // in 2D, z stays an attribute
  bool neighbors = false;       // wants CellView::neighbors
  bool edge_lengths = false;    // wants CellView::longest_edge
  bool final = false;           // holds CellView::final
  bool cell_columns = false;    // holds CellView::values
  bool tile_as_column = false;  // and has no other place for a cell's tile
  bool floats = false;          // coordinates are of 32 bits
  bool local = false;           // ExportOptions::local makes sense: the format has no place on a map
  // Vertices, and cells, that its readers can number; `instead` is what to take for more, or for 3D.
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  const char* instead;
  OpenedWriter (*open)(const std::filesystem::path& path, const MeshHead& head);
  // The file that tells of `files`, which stand beside it; or null. It stands beside a merged file only if
  // `index_of_one`, else only over tiles.
  std::string (*index)(const MeshHead& head, const std::vector<std::string>& files) = nullptr;
  const char* index_ending = "";
  bool index_of_one = false;
};

std::span<const Format> formats();

OpenedWriter open_ply(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_vtu(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_off(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_obj(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_stl(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_glb(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_medit(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_gmsh(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_gmsh_binary(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_dxf(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_landxml(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_npy(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_geojson(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_geopackage(const std::filesystem::path& path, const MeshHead& head);
OpenedWriter open_csv(const std::filesystem::path& path, const MeshHead& head);

std::string pvtu_index(const MeshHead& head, const std::vector<std::string>& files);
std::string vrt_index(const MeshHead& head, const std::vector<std::string>& files);

}  // namespace tessera::exports
