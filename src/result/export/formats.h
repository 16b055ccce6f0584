// The table of all export formats: for --help, for refusals, and for opening writers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "src/result/export/export.h"
#include "src/result/export/mesh_writer.h"

namespace tessera::exports {

struct MeshSource;

enum class Shape : std::uint8_t {
  file,    // one file for all tiles, or a folder with one file a tile
  folder,  // a folder of arrays for all tiles
};

struct Format {
  const char* name;          // value of --format
  const char* ending;        // of the files
  const char* ending2 = "";  // also accepted in --output
  const char* summary;       // for --help
  bool in_3d = true;         // every format holds 2D results
  Shape shape = Shape::file;
  bool corners = false;         // cells carry coordinates and rows; there is no list of vertices
  bool vertex_layer = false;    // but there is a list of vertices with attributes, if there are any
  bool crs = false;             // stores the coordinate system
  bool attributes = false;      // stores the attributes of the vertices
  bool vectors = false;         // attributes may have several components
  bool heights_apart = false;   // in 2D, z stays an attribute
  bool neighbors = false;       // wants CellView::neighbors
  bool edge_lengths = false;    // wants CellView::longest_edge
  bool final = false;           // stores CellView::final
  bool cell_columns = false;    // stores CellView::values
  bool tile_as_column = false;  // and has no other place for a cell's tile
  bool floats = false;          // coordinates have 32 bits
  bool local = false;           // ExportOptions::local makes sense, because the format has no place on a map
  // The most vertices and the most cells that readers of the format can number. `instead` names formats for larger
  // results, or for 3D.
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  const char* instead;
  OpenedWriter (*open)(const std::filesystem::path& path, const MeshHead& head) = nullptr;
  // Instead of `open`, for files that are no lists of vertices and cells: writes the whole result to one file, and the
  // file beside it that `index_ending` names.
  Result<Exported> (*write)(const MeshSource& source, const std::filesystem::path& path) = nullptr;
  bool chooses_columns = false;  // ExportOptions::names makes sense
  // Makes the text of an index file beside `files`; or null. The index is written beside a folder's files, and beside a
  // merged file only if `index_of_one` is set.
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

Result<Exported> write_npy_table(const MeshSource& source, const std::filesystem::path& path);
Result<Exported> write_fits(const MeshSource& source, const std::filesystem::path& path);
Result<Exported> write_hdf5(const MeshSource& source, const std::filesystem::path& path);
Result<Exported> write_zobov(const MeshSource& source, const std::filesystem::path& path);
Result<Exported> write_zobov_doubles(const MeshSource& source, const std::filesystem::path& path);
Result<Exported> write_ndnet(const MeshSource& source, const std::filesystem::path& path);

std::string pvtu_index(const MeshHead& head, const std::vector<std::string>& files);
std::string vrt_index(const MeshHead& head, const std::vector<std::string>& files);

}  // namespace tessera::exports
