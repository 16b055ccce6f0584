// Lines of the surface of a 2D result: contour lines and profiles (docs/terrain.md).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

class TESSERA_PUBLIC ContourRequest {
 public:
  // `interval`: between levels, in units of the heights, above 0.
  explicit ContourRequest(double interval);
  ContourRequest(const ContourRequest&);
  ContourRequest& operator=(const ContourRequest&);
  ~ContourRequest();

  // A level; 0 by default.
  ContourRequest& base(double level);
  // xmin, ymin, xmax, ymax: only lines in the cells that meet it, uncut; default: all.
  ContourRequest& bbox(const std::array<double, 4>& box);
  // No lines in cells with a longer edge in the plane.
  ContourRequest& max_edge(double length);
  // An attribute of the vertices; "z", the heights, by default.
  ContourRequest& value(const std::string& name);
  // Replace a file of the same name.
  ContourRequest& overwrite(bool overwrite);
  // For tiles and lines; 0: 70 % of what is free.
  ContourRequest& memory_bytes(std::uint64_t bytes);
  // 0: all processors.
  ContourRequest& threads(unsigned threads);
  ContourRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Programs have its size compiled in: it stays as it is.
struct LineSet {
  std::vector<double> values;          // the level of each of n lines, ascending
  std::vector<std::uint64_t> offsets;  // n + 1: line i has the points offsets[i] to offsets[i + 1] - 1
  std::vector<double> points;          // x, y of each; the last one of a closed line is its first
};

// The lines are a function of the triangulation alone. Failure: usage for a 3D result, and when there is no such
// attribute; memory when they do not fit; corrupt, io, interrupted.
TESSERA_PUBLIC LineSet draw_contours(const Triangulation& triangulation, const ContourRequest& request);
// The same lines as a GeoPackage or GeoJSON, by the target's ending, whole or not at all. Returns a sentence when the
// coordinates have no system, else "". Failure: also usage when `target` exists or ends otherwise.
TESSERA_PUBLIC std::string write_contours(const Triangulation& triangulation, const std::filesystem::path& target,
                                          const ContourRequest& request);

class TESSERA_PUBLIC ProfileRequest {
 public:
  ProfileRequest();
  ProfileRequest(const ProfileRequest&);
  ProfileRequest& operator=(const ProfileRequest&);
  ~ProfileRequest();

  // Nothing in cells with a longer edge in the plane.
  ProfileRequest& max_edge(double length);
  // An attribute of the vertices; "z", the heights, by default.
  ProfileRequest& value(const std::string& name);
  // Replace a file of the same name.
  ProfileRequest& overwrite(bool overwrite);
  // For tiles and what is found in them; 0: 70 % of what is free.
  ProfileRequest& memory_bytes(std::uint64_t bytes);
  ProfileRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
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
// The same as CSV, whole or not at all. Failure: also usage when `target` exists.
TESSERA_PUBLIC void write_profile(const Triangulation& triangulation, std::span<const double> line,
                                  const std::filesystem::path& target, const ProfileRequest& request = {});

}  // namespace tessera
