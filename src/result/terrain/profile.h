// The heights of a 2D result along a line, or another attribute of its vertices.
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

// Values of `digits` below: as many decimals as the data carry (profile.cc), and all digits that are needed to read the
// same double back.
inline constexpr int digits_of_data = -1, digits_all = -2, digits_most = 17;

struct ProfileOptions {
  std::string value = "z";                              // an attribute of the vertices; z has the heights
  std::optional<double> max_edge = {};                  // cells with a longer edge in the plane are ignored
  std::optional<double> max_radius = {};                // and cells with a larger circumradius
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // for the cells of a leg, in addition to the memory of `result`
  int digits = digits_of_data;                          // decimals in CSV: digits_of_data, digits_all, 0 to digits_most
  std::stop_token stop = {};
};

struct ProfilePoint {
  double distance = 0;  // from the beginning of the line, in the plane
  double x = 0, y = 0;
  double value = 0;
  std::uint64_t part = 0;  // the surface joins points of one part; between parts there is no surface
};

// Returns the points where the line begins, bends and ends on the surface, and where it crosses or touches an edge or
// meets a vertex. So the surface is linear between successive points of a part. The set of points, their order, and
// what joins them are exact; positions and values are right to 1e-11 of the cell. The points depend only on the
// triangulation, not on its tiles. REQUIRES: at least two points, finite, with z = 0. Errors: usage for a 3D result, a
// missing attribute, or a line that meets no cell; those of query::StoredTriangulation.
Result<std::vector<ProfilePoint>> profile(const query::StoredTriangulation& result, const std::filesystem::path& out,
                                          std::span<const Point> line, const ProfileOptions& options);

// The CSV that the command writes: a line "distance,x,y,z,part" (with the value's name for z), then one line a point.
std::string to_csv(std::span<const ProfilePoint> points, const ProfileOptions& options);

// Parses "17", "all" or "data". Error usage: why the text is none of them, as the end of a sentence.
Result<int> parse_digits(const std::string& text);
// Error usage for a number that ProfileOptions does not allow.
Status check_digits(int digits);

// Where there is no surface below the line, at its ends and between parts: lengths along the line.
struct ProfileGaps {
  double before = 0, after = 0, between = 0;
  std::uint64_t count = 0;  // number of gaps between parts
};
// REQUIRES: the points are of this line.
ProfileGaps gaps_of(std::span<const ProfilePoint> points, std::span<const Point> line);
// Describes the gaps in a sentence; empty when there are none.
std::string gaps_note(const ProfileGaps& gaps);

}  // namespace tessera
