// Voronoi cells of the points of results, as files (docs/voronoi.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "tessera/failure.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

// Options of write_voronoi(). Without a clip, cells of a 2D result are clipped to the convex hull of the points, and
// cells of a 3D result are left whole. Every function returns *this.
class TESSERA_PUBLIC VoronoiRequest {
 public:
  VoronoiRequest();
  VoronoiRequest(const VoronoiRequest&);
  VoronoiRequest& operator=(const VoronoiRequest&);
  ~VoronoiRequest();

  // Clips to the convex hull of the points, in 2D; or leaves cells whole. Unbounded cells then have no shape.
  VoronoiRequest& clip_to_hull();
  VoronoiRequest& clip_to_nothing();
  // Clips to a box: 4 numbers in 2D, xmin, ymin, xmax, ymax; 6 in 3D. Failure: usage for another number of numbers.
  VoronoiRequest& clip_to_box(std::span<const double> box);
  // Clips to the polygons of a GeoPackage, FlatGeobuf or GeoJSON file, in 2D.
  VoronoiRequest& clip_to_file(const std::filesystem::path& polygons);
  // Replaces an existing file of the same name.
  VoronoiRequest& overwrite(bool overwrite);
  // The memory for tiles; 0, the default: 70 % of the free memory.
  VoronoiRequest& memory_bytes(std::uint64_t bytes);
  // 0, the default: all processors.
  VoronoiRequest& threads(unsigned threads);
  VoronoiRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// What a file of cells has. Programs are compiled with the size of this struct, so it never changes.
struct VoronoiFile {
  std::uint64_t cells = 0;      // that were written
  std::uint64_t unbounded = 0;  // among them; of a 3D result without a clip: not written
  std::uint64_t outside = 0;    // not written, because they do not meet the clip
  double size = 0;              // the sum of the finite areas or volumes
  std::string note;             // a sentence about the coordinates, or ""
};

// Writes the cells, by ascending id: polygons of a 2D result as .gpkg, .fgb, .geojson or .csv, polyhedra of a 3D result
// as .vtu. Corners are computed exactly and rounded once. The file is written whole or not at all. Failure: usage for a
// region, if `target` exists or has another ending, if the clip does not suit the result or no cell meets it; bad_input
// for a file of polygons; corrupt, io, memory, interrupted.
TESSERA_PUBLIC VoronoiFile write_voronoi(const Triangulation& triangulation, const std::filesystem::path& target,
                                         const VoronoiRequest& request);

}  // namespace tessera
