// Lines of the surface of a 2D result: contour lines and profiles (docs/terrain.md).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/surface_request.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

class ContourRequest;
class ProfileRequest;
extern template class TESSERA_PUBLIC SurfaceRequest<ContourRequest>;
extern template class TESSERA_PUBLIC SurfaceRequest<ProfileRequest>;

// Options of draw_contours() and write_contours(). Every function returns *this.
class TESSERA_PUBLIC ContourRequest : public SurfaceRequest<ContourRequest> {
 public:
  // `interval`: the distance between levels, in units of the heights, above 0.
  explicit ContourRequest(double interval);

  // One of the levels; 0 by default. The others are base + k interval.
  ContourRequest& base(double level);
  // Draws only the lines in cells that meet the box xmin, ymin, xmax, ymax. The lines are not cut at the box. Default:
  // all lines.
  ContourRequest& bbox(const std::array<double, 4>& box);
  // Draws the lines of a smooth surface, for maps: the means of the surface in squares of this size, in units of the
  // coordinates. Default: the lines of the triangulated surface itself.
  ContourRequest& smooth(double size);
  // Leaves out lines that are shorter in the plane, closed or not.
  ContourRequest& min_length(double length);
  // The level base + k interval is an index line if `levels` divides k; 5 by default.
  ContourRequest& index_every(std::uint32_t levels);
  // 0, the default: all processors.
  ContourRequest& threads(unsigned threads);
};

// n contour lines. Programs are compiled with the size of this struct, so it never changes.
struct LineSet {
  std::vector<double> values;          // n: the level of each line, ascending
  std::vector<std::uint64_t> offsets;  // n + 1: line i has the points offsets[i] to offsets[i + 1] - 1
  std::vector<double> points;          // x, y of each point; a closed line ends with its first point
  std::vector<std::uint8_t> index;     // n: 1 for index lines, else 0
};

// Returns contour lines. The lines depend on the triangulation alone, not on its tiles. Failure: usage for a 3D result
// and for an attribute that the result does not have; memory when the lines do not fit; corrupt, io, interrupted.
TESSERA_PUBLIC LineSet draw_contours(const Triangulation& triangulation, const ContourRequest& request);
// Writes the same lines as a GeoPackage (.gpkg) or GeoJSON (.geojson, .json). The file is written whole or not at all.
// Returns a sentence if the coordinates have no coordinate system, else "". Failure: also usage if `target` exists or
// has another ending.
TESSERA_PUBLIC std::string write_contours(const Triangulation& triangulation, const std::filesystem::path& target,
                                          const ContourRequest& request);

// Options of draw_profile() and write_profile(). Every function returns *this.
class TESSERA_PUBLIC ProfileRequest : public SurfaceRequest<ProfileRequest> {
 public:
  ProfileRequest();

  // The number of decimals in CSV, 0 to 17; by default the precision that the data have.
  ProfileRequest& digits(int decimals);
  // Writes so many digits in CSV that the same doubles are read back.
  ProfileRequest& all_digits();
};

// The points where a profile can bend, in the order of the line: where the line begins, bends and ends on the surface,
// and where it meets edges and vertices. Programs are compiled with the size of this struct, so it never changes.
struct ProfileTable {
  std::vector<double> distances;     // from the beginning of the line, in the plane
  std::vector<double> points;        // x, y of each point
  std::vector<double> values;        // of the surface
  std::vector<std::uint64_t> parts;  // the surface joins points of the same part; between parts there is a gap
};

// Returns the profile of the surface along `line`, which has x, y of at least two points. Failure: usage for a 3D
// result, for an attribute that the result does not have, and for a line that is malformed or meets no cell; corrupt,
// io, memory, interrupted.
TESSERA_PUBLIC ProfileTable draw_profile(const Triangulation& triangulation, std::span<const double> line,
                                         const ProfileRequest& request = {});
// Writes the same profile as CSV. The file is written whole or not at all. Returns a sentence if parts of the line have
// no surface below them, else "". Failure: also usage if `target` exists.
TESSERA_PUBLIC std::string write_profile(const Triangulation& triangulation, std::span<const double> line,
                                         const std::filesystem::path& target, const ProfileRequest& request = {});

}  // namespace tessera
