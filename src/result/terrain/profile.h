// The heights of a 2D result along a line, or any other value of its vertices.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera {

// Of `digits` below: as many decimals as the data carry (profile.cc), and those that read back as the same double.
inline constexpr int digits_of_data = -1, digits_all = -2, digits_most = 17;

struct ProfileOptions {
  std::string value = "z";              // an attribute of the vertices; z are the heights
  std::optional<double> max_edge = {};  // cells with a longer edge in the plane are not part of the surface
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // for the cells of a leg, beside what `result` may hold
  int digits = digits_of_data;                          // decimals in CSV: digits_of_data, digits_all, 0 to digits_most
  std::stop_token stop = {};
};

struct ProfilePoint {
  double distance = 0;  // from the line's beginning, in the plane
  double x = 0, y = 0;
  double value = 0;
  std::uint64_t part = 0;  // points of one part are joined by the surface; between parts there is none
};

// Where the line begins, bends and ends on the surface, and where it crosses or touches an edge or meets a vertex: so
// the surface is linear between one point and the next of the same part. Which points there are, in which order, and
// what joins them, is exact; places and values are right to 1e-11 of the cell. A function of the triangulation, however
// the result is tiled. REQUIRES: at least two points, finite, with z = 0. Errors: usage for a 3D result, no such
// attribute, a line that meets no cell; of query::StoredTriangulation.
Result<std::vector<ProfilePoint>> profile(const query::StoredTriangulation& result, const std::filesystem::path& out,
                                          std::span<const Point> line, const ProfileOptions& options);

// What the command writes: a line "distance,x,y,z,part" (or the value's name for z), then a line a point.
std::string to_csv(std::span<const ProfilePoint> points, const ProfileOptions& options);

// "17", or "all" or "data". Error usage: why it is none of them, as the end of a sentence.
Result<int> parse_digits(const std::string& text);
// Error usage for another number than ProfileOptions takes.
Status check_digits(int digits);

// Where there is no surface below the line: at its ends, between parts. In lengths along the line.
struct ProfileGaps {
  double before = 0, after = 0, between = 0;
  std::uint64_t count = 0;  // of those between
};
// REQUIRES: points of this line.
ProfileGaps gaps_of(std::span<const ProfilePoint> points, std::span<const Point> line);
// A sentence that says so; empty when there are none.
std::string gaps_note(const ProfileGaps& gaps);

}  // namespace tessera
