// Parts of 3D results for viewers, as binary glTF: the hull, a section, tetrahedra.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera::tileset {

// Each cell has vertices of its own, one after the other, so that it can be known, coloured and shrunk by itself.
struct ShapeVertex {
  Point at;
  std::uint32_t of = 0;  // the place of its cell in the set
  std::uint16_t intensity = 0;
  std::uint8_t classification = 0;
};
struct Shape {
  std::string kind;  // "hull", "section" or "solids"
  std::vector<ShapeVertex> vertices;
  std::vector<std::uint32_t> corners;  // three a triangle, counter-clockwise from outside, or from above the plane
  std::vector<double> lengths = {};    // of the hull: of the longest edges of all cells, every hundredth
};

// Of each facet three vertices.
Shape hull_shape(const query::HullCells& hull);
// What the plane cuts out of each cell: a triangle, or four corners in two triangles. On both sides of a facet it has
// the same corners. What is wholly outside of the box is left out.
Shape section_shape(const query::CellSet& cells, const query::Plane& plane, const Bounds& box);
// Of each cell four vertices, drawn towards their mean: 1 leaves them where they are.
Shape solids_shape(const query::CellSet& cells, double shrink);

// Coordinates are relative to a whole number near the middle of the result; the scene's extras tell it, and what there
// is to colour by. Vertices have _INTENSITY, _CLASSIFICATION, _TILE and _CELL, the main tile of the cell and its place
// in that tile's file (as two halves). Without vertices the scene has no nodes.
std::vector<std::byte> to_glb(const Shape& shape, const query::CellSet& cells, const Manifest& manifest);

}  // namespace tessera::tileset
