// On which side of a ray points lie: exactly, and never in doubt.
//
// A ray begins at a vertex p and goes towards a sensor s, or away from it. The sensor is moved by (e, e^2, e^3), e
// greater than 0 and less than anything else: a function of coordinates alone, so that all tiles agree, after which a
// ray passes no edge and no vertex but p.
#pragma once

#include "src/base/point.h"

namespace tessera::surface {

// The sign of det(s - p, a - p, b - p) with s moved; 0 only if p, a and b lie on one line.
int side_of_line(const Point& p, const Point& s, const Point& a, const Point& b);
// Whether s, moved, is on the side of the plane from which a, b, c stand counterclockwise. They are on no line.
bool is_beyond(const Point& a, const Point& b, const Point& c, const Point& s);

}  // namespace tessera::surface
