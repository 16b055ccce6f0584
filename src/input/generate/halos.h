// A made-up universe: clumps of particles, as simulations of the growth of structure have them.
#pragma once

#include <cstdint>

#include "src/base/point.h"
#include "src/base/random.h"

namespace tessera {

// Particles in the periodic cube (in 2D square) from 0 to 1. Every fifth particle lies anywhere. The others are in
// halos at random places. A halo of m particles has the mean density of 200 times that of the cube, and its density
// falls with the square of the distance from its centre (in 2D with the distance), as in the singular isothermal sphere
// (Binney, Tremaine, Galactic Dynamics, section 4.3.3). So one
// particle of fifty has a density of more than 10^5 times the mean. The number of halos with more than m particles
// falls as 1 / m (Press, Schechter, The Astrophysical Journal 187 (1974), for small masses). The least halo has 20
// particles, the largest the hundredth part of all.
class Halos {
 public:
  Halos(std::uint64_t points, std::uint64_t seed, int dimension);

  // Returns the next particle; those of a halo follow each other.
  Point next();

 private:
  void begin_halo();
  Point anywhere();

  Random random_;
  int dimension_;
  double particles_, most_;
  std::uint64_t made_ = 0;
  std::uint64_t left_ = 0;  // particles of the halo that are still to come
  Point centre_;
  double radius_ = 0;
};

}  // namespace tessera
