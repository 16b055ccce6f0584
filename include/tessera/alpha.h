// Alpha shapes of results (docs/alpha.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

// Options of make_alpha_shape() and write_alpha_shape(). Every function returns *this.
class TESSERA_PUBLIC AlphaRequest {
 public:
  AlphaRequest();
  AlphaRequest(const AlphaRequest&);
  AlphaRequest& operator=(const AlphaRequest&);
  ~AlphaRequest();

  // Cells of a circumradius up to `radius`, compared exactly, make the shape. In units of the coordinates, finite and
  // above 0. Default: the least radius for which the shape is one piece that has all points.
  AlphaRequest& alpha(double radius);
  // Also singular facets, edges and vertices.
  AlphaRequest& general(bool general);
  // Replaces an existing file of the same name.
  AlphaRequest& overwrite(bool overwrite);
  // The memory for tiles and sorting; 0, the default: 70 % of the free memory.
  AlphaRequest& memory_bytes(std::uint64_t bytes);
  // 0, the default: all processors.
  AlphaRequest& threads(unsigned threads);
  AlphaRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// An alpha shape with n vertices. Facets are triangles in 3D, counterclockwise seen from outside, and edges in 2D, with
// the shape on their left. In a periodic result vertices are images: a point can be several of them, those in the box
// come first, and a coordinate divided by the period and rounded down is how many periods a vertex lies away. The
// boundary is closed up to shifts by periods. Programs are compiled with the size of this struct, so it never changes.
struct AlphaSurface {
  double radius = 0;
  std::uint64_t cells = 0;                       // cells in the shape
  std::vector<std::uint64_t> ids;                // n: the source indices of the vertices, ascending
  std::vector<double> points;                    // n x dimension: their coordinates
  std::vector<std::uint64_t> facets;             // m x dimension: the boundary, by places in `ids`
  std::vector<std::uint64_t> singular_facets;    // likewise
  std::vector<std::uint64_t> singular_edges;     // in 3D: k x 2
  std::vector<std::uint64_t> singular_vertices;  // places in `ids`
};

// Returns an alpha shape. The shape depends on the triangulation alone, not on its tiles. Failure: usage for a wrong
// radius and for a region; memory when the shape does not fit; corrupt, io, interrupted.
TESSERA_PUBLIC AlphaSurface make_alpha_shape(const Triangulation& triangulation, const AlphaRequest& request);
// Writes the same shape as .ply; of a 2D result also polygons as .gpkg, .geojson or .fgb. The file is written whole or
// not at all. Returns the radius. Failure: also usage if `target` exists or has another ending, and if no cell is in
// the shape.
TESSERA_PUBLIC double write_alpha_shape(const Triangulation& triangulation, const std::filesystem::path& target,
                                        const AlphaRequest& request);

}  // namespace tessera
