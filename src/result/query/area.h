// The area of a query: a closed box; or a closed polygon in the plane with all that is above and below it; or a line in
// the plane; or a plane in space.
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

// Decides exactly, by separating axes, whether a cell (3 points in the plane or 4 in space) and a closed box have a
// point in common. REQUIRES: the cell is positively oriented, the box is finite, and lo is not above hi.
bool meets(std::span<const Point> cell, const Bounds& box);

// A line segment between two points of the plane, which may be equal; z = 0.
struct Leg {
  Point from, to;
};
// The same for a triangle and a closed segment.
bool meets(std::span<const Point> cell, const Leg& leg);

// A set of rings with their insides, by the even-odd rule: holes are rings, too. Closed: the rings belong to the
// polygon.
class Polygon {
 public:
  // Each ring has at least 3 vertices, the first not repeated, with z = 0; there are fewer than 2^28 vertices in all.
  // The polygon needs bytes_of_edge bytes for each vertex, whatever its shape.
  static constexpr std::uint64_t bytes_of_edge = 104;
  explicit Polygon(std::vector<std::vector<Point>> rings);
  // Reads the polygons of a GeoJSON file (a geometry, a feature, or a collection of them; Polygon and MultiPolygon),
  // with unchanged coordinates. Errors: io; bad_input with file and place; those of the thread's ledger, when it has no
  // memory left for the edges.
  static Result<Polygon> read_geojson(const std::filesystem::path& path);
  // The same for the text of such a file; errors name it `name`.
  static Result<Polygon> of_geojson(std::string_view text, const std::string& name);

  const Bounds& bounds() const { return bounds_; }
  const GeoJsonFrame& place() const { return place_; }  // of a file
  // Exact. For a cell in space, its projection to the plane is used.
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

  GeoJsonFrame place_;
  Bounds bounds_;
  std::vector<Edge> edges_;
  // Strips of y, and the edges that meet each strip: those of strip s are met_[begin_[s]] up to met_[begin_[s + 1]].
  std::vector<std::uint32_t> met_, begin_;
};

// A plane in space.
struct Plane {
  Point at, normal;  // a point of the plane; the normal has length 1, up to rounding
  // The distance above the plane, rounded. Depends on the point alone, so all cells with the same vertex agree on the
  // side of the vertex.
  double above(const Point& p) const {
    return normal.x * (p.x - at.x) + normal.y * (p.y - at.y) + normal.z * (p.z - at.z);
  }
};

struct Area {
  Bounds box;                           // closed; sides may be infinite
  std::optional<Polygon> polygon = {};  // the box has its bounds in x and y
  std::optional<Leg> leg = {};          // for 2D results; the box has its bounds, too
  // For 3D results: cells that meet the box and have vertices on both sides of the plane, or within rounding of it.
  // These are all cells that meet the plane inside the box, and perhaps others.
  std::optional<Plane> plane = {};
  // Cells with a longer edge, in 2D measured in the plane, are left out.
  std::optional<double> max_edge = {};
  std::optional<double> max_radius = {};  // likewise cells with a larger circumradius
};

}  // namespace tessera::query
