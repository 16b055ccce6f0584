// Polygons of files of maps: GeoPackage, GeoJSON, FlatGeobuf and Shapefile, read by GDAL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/geojson.h"

namespace tessera::query {

// A polygon or several that are one feature.
struct MapFeature {
  std::int64_t number = 0;  // in the file
  std::string name;         // the value of the attribute that names it; empty if there is none
  // The rings of each polygon, with at least 3 vertices each, the first not repeated.
  std::vector<std::vector<std::vector<Point>>> polygons;
  std::vector<std::byte> wkb;  // the geometry as it was read
};

struct MapFileOptions {
  std::string name = {};        // the attribute that names polygons; empty: "name" or "id", if there is one
  bool heights = false;         // vertices must have heights; else z = 0
  bool must_be_valid = false;   // refuse polygons that OGC's rules forbid, such as those that cross themselves
  std::uint64_t bytes_max = 0;  // for all vertices; 0: no bound but that of the ledger
  std::uint64_t bytes_of_vertex = 0;
};

// Calls take(feature) for all polygons of the only layer of a file. Returns what is known of their coordinates. An
// error bad_input of `take` is the end of a sentence about the feature. Errors: io; usage when there is no such
// attribute; bad_input, with file, feature and reason, for a geometry that is no polygon, is not valid, has a
// coordinate that is not finite, or lacks heights, and for a file without polygons; memory; those of `take`.
Result<GeoJsonFrame> read_map_polygons(const std::filesystem::path& path, const MapFileOptions& options,
                                       const std::function<Status(MapFeature&)>& take);

}  // namespace tessera::query
