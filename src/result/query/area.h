// Where cells are asked for: a closed box, or in the plane a closed polygon, and whatever is above and below it, or a
// line, or a plane of space.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/geojson.h"

namespace tessera::query {

// Whether a cell, 3 points of the plane or 4 of space, and a closed box have a point in common: exact, by separating
// axes. REQUIRES: the cell is positively oriented, the box finite, and its lo not above its hi.
bool meets(std::span<const Point> cell, const Bounds& box);

// A line from one point of the plane to another, or to itself; z = 0.
struct Leg {
  Point from, to;
};
// The same for a triangle and the closed line.
bool meets(std::span<const Point> cell, const Leg& leg);

// Rings with their insides, by the even-odd rule: holes are rings, too. Closed: rings belong to it.
class Polygon {
 public:
  // Each ring at least 3 vertices, the first not repeated, z = 0; fewer than 2^28 in all. Takes bytes_of_edge bytes for
  // each vertex, whatever the polygon looks like.
  static constexpr std::uint64_t bytes_of_edge = 104;
  explicit Polygon(std::vector<std::vector<Point>> rings);
  // The polygons of a GeoJSON file (a geometry, a feature, or a collection of them; Polygon and MultiPolygon), with
  // coordinates as they are. Errors: io; bad_input that names the file and the place; of the thread's ledger, when
  // its memory has no room for the edges.
  static Result<Polygon> read_geojson(const std::filesystem::path& path);
  // The same of the text of such a file; `name`: what errors call it.
  static Result<Polygon> of_geojson(std::string_view text, const std::string& name);

  const Bounds& bounds() const { return bounds_; }
  const GeoJsonPlace& place() const { return place_; }  // of a file
  // Exact. Of a cell of space it is the projection that counts.
  bool meets(std::span<const Point> cell) const;

 private:
  struct Edge {
    Point a, b;  // a.y <= b.y
  };
  static Result<Polygon> of_shapes(GeoJsonShapes shapes);
  bool meets_triangle(const Point& a, const Point& b, const Point& c) const;
  bool contains(const Point& p) const;
  std::size_t strip(double y) const;  // clamped

  std::size_t strips() const { return begin_.size() - 1; }
  std::span<const std::uint32_t> edges_in(std::size_t strip) const {
    return std::span(met_).subspan(begin_[strip], begin_[strip + 1] - begin_[strip]);
  }
  std::uint64_t index_strips(std::size_t strips);

  GeoJsonPlace place_;
  Bounds bounds_;
  std::vector<Edge> edges_;
  // Strips of y, and the edges that meet each of them: those of strip s are met_[begin_[s]] up to met_[begin_[s + 1]].
  std::vector<std::uint32_t> met_, begin_;
};

// A plane of space.
struct Plane {
  Point at, normal;  // a point of it; the normal has length 1, but for rounding
  // How far it is above the plane, rounded: a function of the point alone, so that all cells with a vertex agree on
  // which side it is.
  double above(const Point& p) const {
    return normal.x * (p.x - at.x) + normal.y * (p.y - at.y) + normal.z * (p.z - at.z);
  }
};

struct Area {
  Bounds box;                           // closed; sides may be infinite
  std::optional<Polygon> polygon = {};  // whose bounds in x and y the box is
  std::optional<Leg> leg = {};          // of 2D results, likewise
  // Of 3D results: cells that meet the box, and have vertices on both sides of the plane or as near to it as rounding
  // is: all that meet the plane inside the box, and it may be others beside them.
  std::optional<Plane> plane = {};
  // Cells with a longer edge are left out: in the plane in 2D.
  std::optional<double> max_edge = {};
};

}  // namespace tessera::query
