// The alpha shape of a result: what is left of its triangulation when only cells of small circumradius count.
//
// Definitions. R is a radius in units of the coordinates. A cell is in the shape when its circumradius is at most R,
// compared exactly. A facet of exactly one such cell is on the boundary, which is thus closed; its orientation is
// outward: counterclockwise seen from outside in 3D, with the shape on the left in 2D. The general shape also has the
// singular faces: faces of cells that are in the alpha complex, and are no faces of another simplex in the complex. A
// facet or edge of no cell in the shape is in the complex when the smallest sphere through its vertices has a radius of
// at most R and no vertex strictly inside. A vertex is always in the complex. This is CGAL's mode GENERAL, where in
// 2D the vertices of singular edges are singular, too; CGAL's alpha is the square of R. Source: Edelsbrunner, Muecke,
// Three-dimensional alpha shapes, ACM Transactions on Graphics 13 (1994).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

struct AlphaOptions {
  std::optional<double> radius = {};  // nothing: the least one for which the shape is one piece with all points
  bool general = false;               // also singular faces
  bool overwrite = false;             // replace an existing file
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // at least the memory of one tile is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // gets the fraction done, 0..1, from one thread at a time; may be null
};

struct AlphaShape {
  std::filesystem::path path;
  double radius = 0;
  bool searched = false;  // whether the radius was searched
  bool general = false;   // whether singular faces were asked for
  std::uint64_t cells = 0;
  std::uint64_t vertices = 0;  // that the file has
  std::uint64_t facets = 0, singular_facets = 0, singular_edges = 0, singular_vertices = 0;
  std::uint64_t polygons = 0, holes = 0;  // in a map file
  std::uint64_t bytes = 0;                // of the file
  std::string note = {};                  // a sentence when the coordinates have no coordinate system; else empty
};

// One line of JSON, without its end, for the command's output.
std::string to_json(const AlphaShape& shape);

// The radius as text, which is read back as the same number.
std::string radius_text(double radius);

// Writes `target`: as .ply vertices and facets; in 2D as .gpkg, .geojson, .json or .fgb one polygon, with its holes,
// for each piece of the shape. The file depends on the triangulation and the radius alone, not on its tiles. Each tile
// is read once, or twice when the radius is searched. What is found is sorted in unnamed files in the target's folder.
// A polygon is in memory while it is written. Errors: usage, before anything is written, for a wrong radius, a region,
// an existing target, a format that cannot hold the shape; corrupt for a damaged tile; io; interrupted.
Result<AlphaShape> write_alpha_shape(const std::filesystem::path& out, const std::filesystem::path& target,
                                     const AlphaOptions& options, std::stop_token stop);

// The same shape in memory. Vertices are numbered in the order of their ids. In a periodic result vertices are images:
// those in the box come first, and then images by their offset. A point can be several vertices.
struct AlphaArrays {
  double radius = 0;
  std::uint64_t cells = 0;
  std::vector<std::uint64_t> ids;                // n source indices, ascending; see images below
  std::vector<double> points;                    // n x dimension coordinates
  std::vector<std::uint64_t> facets;             // each `dimension` indices of vertices
  std::vector<std::uint64_t> singular_facets;    // likewise
  std::vector<std::uint64_t> singular_edges;     // in 3D: each 2 indices
  std::vector<std::uint64_t> singular_vertices;  // indices
};
// What does not fit into memory while the shape is made is kept in the system's temporary folder. Errors: as
// write_alpha_shape(); memory when the arrays do not fit.
Result<AlphaArrays> make_alpha_shape(const std::filesystem::path& out, const AlphaOptions& options,
                                     std::stop_token stop);

}  // namespace tessera
