#include "src/export/formats.h"

namespace tessera::exports {

namespace {

constexpr std::uint64_t int32_max = std::numeric_limits<std::int32_t>::max();
constexpr std::uint64_t uint32_max = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t int64_max = std::numeric_limits<std::int64_t>::max();

constexpr Format table[] = {
    {.name = "ply",
     .ending = ".ply",
     .summary = "PLY, binary: points with attributes, faces or (3D) cells of 4 vertices",
     .attributes = true,
     .most = uint32_max,
     .instead = "vtu",
     .open = open_ply},
    {.name = "vtu",
     .ending = ".vtu",
     .summary = "VTK XML, binary: points with attributes, cells; over tiles also a .pvtu",
     .attributes = true,
     .most = int64_max,
     .instead = "npy",
     .open = open_vtu,
     .index = pvtu_index,
     .index_ending = ".pvtu"},
    {.name = "off",
     .ending = ".off",
     .summary = "OFF, text: points and cells",
     .most = uint32_max,
     .instead = "vtu",
     .open = open_off},
    {.name = "obj",
     .ending = ".obj",
     .summary = "Wavefront OBJ, text: points and triangles (2D)",
     .in_3d = false,
     .most = int32_max,
     .instead = "ply",
     .open = open_obj},
    {.name = "mesh",
     .ending = ".mesh",
     .summary = "MEDIT, text: points and cells, for MEDIT, Mmg, Gmsh",
     .most = int32_max,
     .instead = "vtu",
     .open = open_medit},
    {.name = "msh",
     .ending = ".msh",
     .summary = "Gmsh 2.2, text: points and cells, for Gmsh, HXT, meshio",
     .most = int32_max,
     .instead = "vtu",
     .open = open_gmsh},
    {.name = "npy",
     .ending = ".npy",
     .summary = "a folder of NumPy arrays: points, ids, cells, neighbors, tile, attributes",
     .shape = Shape::folder,
     .attributes = true,
     .heights_apart = true,
     .neighbors = true,
     .most = int64_max,
     .instead = "vtu",
     .open = open_npy},
    {.name = "geojson",
     .ending = ".geojson",
     .summary = "GeoJSON: a polygon for each triangle (2D)",
     .in_3d = false,
     .corners = true,
     .instead = "ply",
     .open = open_geojson},
    {.name = "gpkg",
     .ending = ".gpkg",
     .summary = "GeoPackage: a polygon for each triangle, with a spatial index (2D)",
     .in_3d = false,
     .corners = true,
     .instead = "ply",
     .open = open_geopackage},
    {.name = "csv",
     .ending = ".csv",
     .ending2 = ".vrt",
     .summary = "CSV: a WKT polygon for each triangle, and the .vrt that makes it a layer (2D)",
     .in_3d = false,
     .corners = true,
     .instead = "ply",
     .open = open_csv,
     .index = vrt_index,
     .index_ending = ".vrt",
     .index_of_one = true},
};

}  // namespace

std::span<const Format> formats() { return table; }

}  // namespace tessera::exports
