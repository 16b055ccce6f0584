// What makes a facet of the triangulation likely to be surface: the weights of the cut, as whole numbers.
//
// Soft visibility after P. Labatut, J.-P. Pons and R. Keriven, Robust and efficient surface reconstruction from range
// data, Computer Graphics Forum 2009, with a scale of its own for each vertex. docs/surfaces.md defines it, with the
// reason of every constant. All is a function of coordinates and ids alone: doubles are only added, subtracted,
// multiplied, divided and rooted, in an order that ids give, so that every tile and machine finds the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "src/base/point.h"

namespace tessera::surface {

// The scale of a vertex, in the median of its edges: points are so near to the surface.
inline constexpr double scale_of_edges = 0.3;
// Of one ray that says for certain which side light was on.
inline constexpr std::uint32_t full_vote = 1u << 12u;

struct Energy {
  double lambda = 1;        // of the quality of facets,
  double alpha = 32;        // to that of one ray's vote
  double ray_length = 100;  // in scales of the ray's vertex: where it ends, before the sensor; infinity: it does not
  double sigma = 0;         // the scale of every vertex, in units of the coordinates; 0: of its own, from its edges
};

// e^-x for x >= 0, to a few units in the last place, and the same bits everywhere; 0 beyond 40.
double exp_of_minus(double x);

// What it costs that a ray's facet, so far from its vertex, is surface, of full_vote at most.
std::uint32_t visibility_weight(double distance, double sigma, std::uint32_t vote);

// A corner of a cell, and who it is.
struct Corner {
  Point at;
  PointId id;
};
// What it costs that a facet is surface, seen from the one cell that has it and from the other, of which there may be
// none: 1 less the least cosine between facet and circumscribed spheres, times lambda. `facet` in any order.
std::uint32_t quality_weight(std::span<const Corner, 3> facet, const Corner& apex, const Corner* other,
                             const Energy& energy);

// Which part of `way` from `from` on, or back, leads to the plane of a facet, whose corners may come in any order; not
// finite when rounding leaves no answer.
double part_to_plane(const Point& from, const Point& way, const Corner& p, const Corner& q, const Corner& r);

// Sums that stop at what a capacity holds, and so are the same in any order.
std::uint32_t saturating(std::uint32_t a, std::uint32_t b);

}  // namespace tessera::surface
