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

// The rings of all polygons of a file (a geometry, a feature, or a collection of them; Polygon and MultiPolygon), each
// of three positions or more, the first not repeated; or its lines (LineString and MultiLineString), each of two or
// more. Coordinates are as they are, z = 0. Errors: io; bad_input that names the file and the place.
Result<std::vector<std::vector<Point>>> read_geojson(const std::filesystem::path& path, GeoJson kind);
// The same of the text of such a file; `name`: what errors call it.
Result<std::vector<std::vector<Point>>> of_geojson(std::string_view text, const std::string& name, GeoJson kind);

}  // namespace tessera::query
