// Parts of 3D results for viewers, as binary glTF: the hull, a section, tetrahedra.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera::tileset {

// Each cell has vertices of its own, one after the other. So viewers can identify, colour and shrink cells one by one.
struct ShapeVertex {
  Point at;
  std::uint32_t of = 0;  // index of its cell in the set
  std::uint16_t intensity = 0;
  std::uint8_t classification = 0;
};
struct Shape {
  std::string kind;  // "hull", "section" or "solids"
  std::vector<ShapeVertex> vertices;
  std::vector<std::uint32_t> corners;  // three a triangle, counterclockwise from outside, or from above the plane
  std::vector<double> lengths = {};    // of the hull: percentiles of the longest edges of all cells
};

// The facets of the hull, with three vertices each.
Shape hull_shape(const query::HullCells& hull);
// The part that the plane cuts out of each cell: a triangle, or four corners in two triangles. The two cells of a facet
// get the same corners on it. Parts wholly outside the box are left out.
Shape section_shape(const query::CellSet& cells, const query::Plane& plane, const Bounds& box);
// The cells as tetrahedra of four vertices, drawn towards their mean by the factor `shrink`; 1 leaves them unchanged.
Shape solids_shape(const query::CellSet& cells, double shrink);

// Converts a shape to binary glTF. Coordinates are relative to an integer point near the middle of the result. The
// scene's extras have that point, and the values by which to colour. Vertices have _INTENSITY, _CLASSIFICATION, _TILE
// and _CELL: the main tile of the cell, and its index in that tile's file (as two halves). Without vertices the scene
// has no nodes.
std::vector<std::byte> to_glb(const Shape& shape, const query::CellSet& cells, const Manifest& manifest);

}  // namespace tessera::tileset
