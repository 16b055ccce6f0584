// What two surfaces enclose between them, over the common part of two or three triangles.
//
// The common part is a convex polygon. Which lines bound the polygon is decided exactly, so triangles that touch, share
// edges or coincide need no care. On the polygon the difference of two linear surfaces is linear, and the line where
// the difference is zero divides the polygon. Areas and volumes are computed in floating point with a bound on their
// error. When the bound is more than 2^-43 of the value (slivers, surfaces that nearly or exactly coincide), they are
// computed again with fractions. So a value is right to 2e-13 of itself, and zero exactly when it is zero.
#pragma once

#include <optional>

#include "src/result/volume/facet.h"

namespace tessera::volume {

// The surfaces over which a piece is computed. The pointers must not be null, unless the comment says so.
struct Sides {
  const Facet* upper = nullptr;  // of the surface A
  const Facet* lower = nullptr;  // of the surface B; null: B is the level plane `level`
  double level = 0;
  const Facet* within = nullptr;  // limits the piece; null: no limit
};

struct Piece {
  double area = 0;   // of the common part of the triangles
  double above = 0;  // the volume between the surfaces where A lies above B
  double below = 0;  // ... where A lies below B
};

// Nothing if the interiors of the triangles have no common point. REQUIRES: finite, counterclockwise triangles. The
// result depends on where a triangle begins (canonical()) in the last bits.
std::optional<Piece> overlay(const Sides& sides);

// The area of the common part of two triangles; 0 if there is none.
double common_area(const Facet& a, const Facet& b);

}  // namespace tessera::volume
