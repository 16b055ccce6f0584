// Small seeded clouds that stress the exchange: degenerate first.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"

namespace tessera {

// uniform, lattice, sphere, clusters, slab, planes, curve, jitter, corners: see clouds.cc.
const std::vector<std::string>& cloud_kinds();

// About n distinct points that span the space, as LocalPoint with ids 0.. in a shuffled order. REQUIRES: kind is one of
// cloud_kinds(), n > dimension.
std::vector<LocalPoint> make_cloud(const std::string& kind, int dimension, std::size_t n, std::uint64_t seed);
// x, y (, z) of each point, as array_source() takes them.
std::vector<double> coordinates_of(const std::vector<LocalPoint>& cloud, int dimension);

}  // namespace tessera
