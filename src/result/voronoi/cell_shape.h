// The polygons of a cell, with rounded corners.
#pragma once

#include <span>
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

// Removes corners that are equal to the corner before them.
void remove_repeated(Ring& ring);
// Turns the ring so that it begins with its least corner, by x and then y.
void begin_with_least(Ring& ring);

// Whether the rings of a part are valid after rounding. Exact: the outer ring runs counterclockwise and the others
// clockwise, no ring meets itself, and no two rings cross.
bool is_valid(std::span<const Ring> part);

}  // namespace tessera::voronoi
