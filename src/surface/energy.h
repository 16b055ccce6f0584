// The weights of the cut, as whole numbers: what makes a facet of the triangulation likely to be surface.
//
// Soft visibility after P. Labatut, J.-P. Pons and R. Keriven, Robust and efficient surface reconstruction from range
// data, Computer Graphics Forum 2009, with a scale for each vertex. docs/surfaces.md defines it, and gives the reason
// of every constant. All functions depend on coordinates and ids alone. They only add, subtract, multiply, divide and
// take square roots of doubles, in an order that ids determine. So every tile and machine computes the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "src/base/point.h"

namespace tessera::surface {

// The scale of a vertex as a part of the median length of its edges: points are about that near to the surface.
inline constexpr double scale_of_edges = 0.3;
// The vote of one ray that says for certain on which side of a facet light was.
inline constexpr std::uint32_t full_vote = 1u << 12u;

struct Energy {
  double lambda = 1;        // weight of the quality of facets
  double alpha = 32;        // weight of one ray's vote
  double ray_length = 100;  // where a ray ends before its sensor, in scales of its vertex; infinity: at the sensor
  double sigma = 0;         // the scale of every vertex, in units of the coordinates; 0: from its own edges
};

// Returns e^-x for x >= 0, to a few units in the last place, with the same bits on every machine; 0 beyond 40.
double exp_of_minus(double x);

// Returns what it costs if a facet that a ray has crossed is surface; at most `vote`. `distance`: from the ray's vertex
// to the facet.
std::uint32_t visibility_weight(double distance, double sigma, std::uint32_t vote);

// A corner of a cell, with its id.
struct Corner {
  Point at;
  PointId id;
};
// Returns what it costs if a facet is surface, by its quality: 1 less the least cosine between the facet and the
// spheres around the cells on both sides, times lambda. `facet` may be in any order; `apex` is the fourth vertex of one
// cell, `other` that of the other cell, or null if there is none.
std::uint32_t quality_weight(std::span<const Corner, 3> facet, const Corner& apex, const Corner* other,
                             const Energy& energy);

// Returns which fraction of `way` leads from `from` to the plane of a facet; negative if the plane lies behind. The
// corners may be in any order. Not finite when rounding leaves no answer.
double part_to_plane(const Point& from, const Point& way, const Corner& p, const Corner& q, const Corner& r);

// Returns a sum that stops at what a capacity can hold. So sums are the same in any order.
std::uint32_t saturating(std::uint32_t a, std::uint32_t b);

}  // namespace tessera::surface
