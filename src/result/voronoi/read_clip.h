// Makes the region to which cells of a 2D result are clipped.
#pragma once

#include <filesystem>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/tile_source.h"
#include "src/result/voronoi/clip_region.h"

namespace tessera::voronoi {

// The convex hull of the points. Errors: those of reading; interrupted.
Result<ClipRegion> hull_region(const TileSource& source, const std::stop_token& stop);
// Error usage when the box is empty.
Result<ClipRegion> box_region(const Bounds& box);
// Whether the ending of the name is one that file_region() reads.
bool is_region_file(const std::filesystem::path& path);
// The polygons of a GeoPackage, FlatGeobuf, Shapefile or GeoJSON file. Errors: usage for another ending; io; bad_input
// when the file has no polygons, or has other coordinates than the result; memory.
Result<ClipRegion> file_region(const std::filesystem::path& path, const Manifest& manifest);

}  // namespace tessera::voronoi
