// What the tiles of a small cloud begin with: which points are whose, and the seeds.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "src/base/point.h"

namespace tessera::testing {

// Ways to give points to tiles; only "stripes" has boxes.
struct Assignment {
  std::vector<std::uint32_t> tile_of;
  std::vector<Box> boxes;
};

// how: random, single, stripes.
Assignment assign(const std::string& how, const std::vector<LocalPoint>& points, std::uint32_t tiles,
                  std::uint64_t seed);

// What every tile is given at the start: the lexicographic minimum, and with it points that span the space (as in
// production) or the extreme points of every tile.
enum class Announced { minimum, spanning, extremes };

std::vector<Seed> make_seeds(const std::vector<LocalPoint>& points, const std::vector<std::uint32_t>& tile_of, int d,
                             Announced announced);
// Any points, each known as far as it happens to be.
void add_random_seeds(const std::vector<LocalPoint>& points, const std::vector<std::uint32_t>& tile_of,
                      std::mt19937_64& rng, std::vector<Seed>& seeds);

}  // namespace tessera::testing
