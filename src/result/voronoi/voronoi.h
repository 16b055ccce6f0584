// Writes the Voronoi cells of the points of a result: polygons in a map file, or polyhedra for ParaView.
//
// The Voronoi cell of a point is what is nearer to it than to all other points. A corner of a cell is the circumcentre
// of a Delaunay cell. Each corner is computed exactly and rounded once (exact_number.h). So cells are closed along
// shared edges to the bit, for every tiling and number of threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

// To what cells are clipped.
enum class VoronoiClip : std::uint8_t { automatic, none, hull, box, file };

struct VoronoiOptions {
  // automatic: the convex hull of the points for a 2D result; none for a 3D one, and for a periodic one. A 3D result
  // knows `none` and `box`, a periodic one `none`: it has the whole cells of the points in the box.
  // Without a limit, unbounded cells have no shape.
  VoronoiClip clip = VoronoiClip::automatic;
  Bounds box = {};                            // for `box`; in 2D without heights
  std::filesystem::path polygons = {};        // for `file`: a GeoPackage, FlatGeobuf or GeoJSON file
  bool overwrite = false;                     // replace an existing file
  std::uint64_t memory_bytes = 0;             // at least the memory of one tile is used
  unsigned threads = 0;                       // 0: one
  std::function<void(double)> progress = {};  // called with the fraction that is done, 0..1; may be null
};

struct WrittenVoronoi {
  std::filesystem::path path;
  int dimension = 2;
  std::uint64_t cells = 0;       // that were written
  std::uint64_t unbounded = 0;   // among them; in 3D without a limit: not written
  std::uint64_t outside = 0;     // not written, because they do not meet the clip
  std::uint64_t shapeless = 0;   // 2D: written without a polygon; 3D: not written
  std::uint64_t thin = 0;        // that lost parts, or all, which are thinner than doubles resolve
  std::uint64_t duplicates = 0;  // points without a cell of their own
  double size = 0;               // the sum of the finite areas or volumes
  std::uint64_t bytes = 0;
  std::string note = {};
};

// One line of JSON.
std::string to_json(const WrittenVoronoi& written);

// Writes the cells of the result folder `out`, by ascending id. The ending of `target` says how: .gpkg, .fgb, .geojson
// and .csv for a 2D result, .vtu for a 3D one. Keeps cells in scratch files beside the target until all are known.
// Errors: usage, before anything is read, for a wrong ending or an existing target; usage for a clip that does not suit
// the result, for a region, and when no cell meets the clip; bad_input for a file of polygons; corrupt for a damaged
// tile; io; memory; interrupted.
Result<WrittenVoronoi> write_voronoi(const std::filesystem::path& out, const std::filesystem::path& target,
                                     const VoronoiOptions& options, std::stop_token stop);

}  // namespace tessera
