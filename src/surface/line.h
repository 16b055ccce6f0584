// Decides on which side of a ray points lie: exactly, and always with an answer.
//
// A ray begins at a vertex p and goes towards a sensor s, or away from it. The sensor is moved by (e, e^2, e^3), where
// e is positive and infinitely small. This perturbation depends on coordinates alone, so all tiles agree. After it a
// ray passes through no edge, and through no vertex but p.
#pragma once

#include "src/base/point.h"

namespace tessera::surface {

// Returns the sign of det(s - p, a - p, b - p), with s moved; 0 only if p, a and b lie on one line.
int side_of_line(const Point& p, const Point& s, const Point& a, const Point& b);
// Whether s, moved, is on the side of the plane from which a, b, c appear counterclockwise. REQUIRES: a, b, c are not
// on one line.
bool is_beyond(const Point& a, const Point& b, const Point& c, const Point& s);

}  // namespace tessera::surface
