// A part of the Voronoi cell of a vertex, or all of it.
#pragma once

#include <cmath>

#include "src/result/query/dual.h"

namespace tessera {

template <class Number>
struct VoronoiPart {
  Number volume = 0;               // in 2D area
  Number surface = 0;              // in 2D length of the boundary
  query::Vec<Number> moment = {};  // the integral of the place relative to the vertex
  long double doubt = 0;           // how large the error of the volume can be, divided by that of one operation

  void add(const VoronoiPart& other) {
    volume += other.volume;
    surface += other.surface;
    moment = moment + other.moment;
    doubt += other.doubt;
  }
};

namespace voronoi {

// Also of numbers that have these functions in their own namespace.
template <class Number>
Number root(const Number& square) {
  using std::sqrt;
  return sqrt(square);
}
template <class Number>
long double long_of(const Number& number) {
  using query::rounded;
  return rounded(number);
}

// Sets the volume, surface and centroid of a vertex at `at` from the sum of its parts.
template <class Number, class Cell>
void fill(Cell& cell, const Point& at, int dimension, const VoronoiPart<Number>& sum) {
  cell.volume = static_cast<double>(long_of(sum.volume));
  cell.surface = static_cast<double>(long_of(sum.surface));
  const Number place[3] = {sum.moment.x, sum.moment.y, sum.moment.z};
  for (int axis = 0; axis < dimension; ++axis)
    cell.centroid[static_cast<std::size_t>(axis)] =
        static_cast<double>(long_of(Number(Number(at[axis]) + place[axis] / sum.volume)));
}

}  // namespace voronoi
}  // namespace tessera
