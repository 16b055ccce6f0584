// Reads shapes from GeoJSON files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::query {

enum class GeoJson : std::uint8_t { polygons, lines };

// What is known of the coordinates of a file.
struct GeoJsonFrame {
  std::string name = {};  // name of the file for errors
  std::string crs = {};   // from its member `crs`, as crs_of_name() returns it; empty when there is none
  Bounds bounds = {};     // of its positions
  // Checks whether the coordinates may be in the coordinate system `there`, in which points have the bounds `points`.
  // Error bad_input, which says what to do: when the file names another system, or when its numbers look like degrees,
  // which GeoJSON means when it names no system, and those of the points do not.
  Status check_in(const std::string& there, const Bounds& points) const;
};

struct GeoJsonShapes {
  std::vector<std::vector<Point>> lists;
  GeoJsonFrame place;
  std::vector<std::size_t> firsts = {};  // of the polygons: the number of the first ring of each
};

// Reads the rings of all polygons of a file (a geometry, a feature, or a collection of them; Polygon and MultiPolygon),
// each with at least three positions, the first not repeated; or its lines (LineString and MultiLineString), each with
// at least two. Coordinates are unchanged, with z = 0; GeoJsonFrame says what is known of them. Errors: io; bad_input
// with file and place.
Result<GeoJsonShapes> read_geojson(const std::filesystem::path& path, GeoJson kind);
// The same for the text of such a file; errors name it `name`.
Result<GeoJsonShapes> of_geojson(std::string_view text, const std::string& name, GeoJson kind);

// For a file that GDAL is to read: GDAL fetches a coordinate system that a member `crs` gives as a link. Errors: io;
// bad_input for a file that is not JSON, and for such a link.
Status check_no_links(const std::filesystem::path& path);

}  // namespace tessera::query
