// Polygons of files of maps: GeoPackage, GeoJSON, FlatGeobuf and Shapefile, read by GDAL.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/geojson.h"
#include "src/result/volume/facet.h"

namespace tessera::volume {

// A polygon or several that are one feature, cut into triangles between its vertices.
struct MapPolygon {
  std::int64_t feature = 0;    // its number in the file
  std::string name;            // the value of the attribute that names it; empty if there is none
  std::vector<Facet> facets;   // canonical; z: the heights of the vertices, or 0
  std::vector<std::byte> wkb;  // the geometry as it was read
};

struct MapPolygons {
  std::vector<MapPolygon> polygons;
  query::GeoJsonFrame frame;  // the coordinate system, as far as it is known, and the bounds
};

struct PolygonOptions {
  std::string name = {};        // the attribute that names polygons; empty: "name" or "id", if there is one
  bool heights = false;         // vertices must have heights
  std::uint64_t bytes_max = 0;  // of the triangles
};

// Reads all polygons of the only layer of a file. Errors: io; usage when there is no such attribute; bad_input, with
// file, feature and reason, for a geometry that is no polygon, is not valid, has a coordinate that is not finite, or
// lacks heights; memory.
Result<MapPolygons> read_polygons(const std::filesystem::path& path, const PolygonOptions& options);

// Cuts the inside of rings (by the even-odd rule) into triangles between their vertices: the constrained Delaunay
// triangulation. Each ring has at least 3 vertices, the first not repeated. Error bad_input: why that is not possible,
// as the end of a sentence.
Result<std::vector<Facet>> triangulate_rings(const std::vector<std::vector<Point>>& rings);

}  // namespace tessera::volume
