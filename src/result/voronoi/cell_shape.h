// The polygons of a cell, with rounded corners.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "src/base/point.h"

namespace tessera::voronoi {

using Ring = std::vector<Point>;  // z = 0; the first corner is not repeated

// The parts of a clipped cell. The first ring of a part runs counterclockwise around it; the others run clockwise
// around its holes. Without parts, nothing is left of the cell.
struct CellShape {
  std::vector<std::vector<Ring>> parts;
};

// What is measured of a polygon whose corners are doubles.
struct ShapeMeasures {
  double area = 0;
  Point centroid{};
};
// REQUIRES: the shape has parts.
ShapeMeasures measure(const CellShape& shape);

// The order of parts in a file, which does not depend on the tile. REQUIRES: rings begin with their least corner.
bool part_before(const std::vector<Ring>& a, const std::vector<Ring>& b);

// Removes corners that are equal to the corner before them.
void remove_repeated(Ring& ring);
// Turns the ring so that it begins with its least corner, by x and then y.
void begin_with_least(Ring& ring);

// Whether the rings of a part are valid after rounding. Exact: the outer ring runs counterclockwise and the others
// clockwise, no ring meets itself, and no two rings cross.
bool is_valid(std::span<const Ring> part);

// A side of a ring: the ring's number in its part, the side's number in its ring, and how many sides the ring has.
struct RingSide {
  Point a, b;
  std::uint32_t ring = 0, number = 0, sides = 0;
};
// Two sides that meet where sides of a valid part do not; nothing when there are none.
std::optional<std::pair<RingSide, RingSide>> find_clash(std::span<const Ring> part);
bool runs_counterclockwise(const Ring& ring);

// A shape as well-known binary: a polygon, or with `multi` a multipolygon; an empty one without parts.
std::vector<std::byte> to_wkb(const CellShape& shape, bool multi);
// Reads what to_wkb() has made.
CellShape shape_of_wkb(std::span<const std::byte> wkb);

}  // namespace tessera::voronoi
