// What GeoJSON files say of places.
#pragma once

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
struct GeoJsonPlace {
  std::string name = {};  // what errors call the file
  std::string crs = {};   // of its member `crs`, as crs_of_name() tells it; empty when there is none
  Bounds bounds = {};     // of its positions
  // Whether they may be in the coordinate system `there`, where there are `points`. Error bad_input, which says what to
  // do, when the file names another system, or when its numbers look like degrees, which GeoJSON means when it says
  // nothing, and those of the points do not.
  Status check_in(const std::string& there, const Bounds& points) const;
};

struct GeoJsonShapes {
  std::vector<std::vector<Point>> lists;
  GeoJsonPlace place;
};

// The rings of all polygons of a file (a geometry, a feature, or a collection of them; Polygon and MultiPolygon), each
// of three positions or more, the first not repeated; or its lines (LineString and MultiLineString), each of two or
// more. Coordinates are as they are, z = 0: GeoJsonPlace says whose they may be. Errors: io; bad_input that names the
// file and the place.
Result<GeoJsonShapes> read_geojson(const std::filesystem::path& path, GeoJson kind);
// The same of the text of such a file; `name`: what errors call it.
Result<GeoJsonShapes> of_geojson(std::string_view text, const std::string& name, GeoJson kind);

}  // namespace tessera::query
