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

class TESSERA_PUBLIC ContourRequest : public SurfaceRequest<ContourRequest> {
 public:
  // `interval`: between levels, in units of the heights, above 0.
  explicit ContourRequest(double interval);

  // A level; 0 by default.
  ContourRequest& base(double level);
  // xmin, ymin, xmax, ymax: only lines in the cells that meet it, uncut; default: all.
  ContourRequest& bbox(const std::array<double, 4>& box);
  // Lines of a smooth surface, for maps: means of the surface in squares of this size, in units of the coordinates.
  ContourRequest& smooth(double size);
  // Without lines that are shorter in the plane, closed or not.
  ContourRequest& min_length(double length);
  // Level base + k interval is an index line when this divides k; 5 by default.
  ContourRequest& index_every(std::uint32_t levels);
  // 0: all processors.
  ContourRequest& threads(unsigned threads);
};

// Programs have its size compiled in: it stays as it is.
struct LineSet {
  std::vector<double> values;          // the level of each of n lines, ascending
  std::vector<std::uint64_t> offsets;  // n + 1: line i has the points offsets[i] to offsets[i + 1] - 1
  std::vector<double> points;          // x, y of each; the last one of a closed line is its first
  std::vector<std::uint8_t> index;     // 1 for each index line, else 0
};

// The lines are a function of the triangulation alone. Failure: usage for a 3D result, and when there is no such
// attribute; memory when they do not fit; corrupt, io, interrupted.
TESSERA_PUBLIC LineSet draw_contours(const Triangulation& triangulation, const ContourRequest& request);
// The same lines as a GeoPackage or GeoJSON, by the target's ending, whole or not at all. Returns a sentence when the
// coordinates have no system, else "". Failure: also usage when `target` exists or ends otherwise.
TESSERA_PUBLIC std::string write_contours(const Triangulation& triangulation, const std::filesystem::path& target,
                                          const ContourRequest& request);

class TESSERA_PUBLIC ProfileRequest : public SurfaceRequest<ProfileRequest> {
 public:
  ProfileRequest();

  // Of CSV: so many decimals of all numbers, 0 to 17; by default as many as the data carry.
  ProfileRequest& digits(int decimals);
  // Of CSV: the digits that read back as the same doubles.
  ProfileRequest& all_digits();
};

// Where the line begins, bends and ends on the surface, and where it meets edges and vertices, in this order. Programs
// have its size compiled in: it stays as it is.
struct ProfileTable {
  std::vector<double> distances;     // from the line's beginning, in the plane
  std::vector<double> points;        // x, y of each
  std::vector<double> values;        // of the surface
  std::vector<std::uint64_t> parts;  // points of one part are joined by the surface; between parts there is none
};

// `line`: x, y of two points or more. Failure: usage for a 3D result, no such attribute, a line that meets no cell or
// is none; corrupt, io, memory, interrupted.
TESSERA_PUBLIC ProfileTable draw_profile(const Triangulation& triangulation, std::span<const double> line,
                                         const ProfileRequest& request = {});
// The same as CSV, whole or not at all. Returns a sentence when there is no surface below some of the line, else "".
// Failure: also usage when `target` exists.
TESSERA_PUBLIC std::string write_profile(const Triangulation& triangulation, std::span<const double> line,
                                         const std::filesystem::path& target, const ProfileRequest& request = {});

}  // namespace tessera
