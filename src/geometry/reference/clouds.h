// Small random clouds for tests, reproducible from a seed. Most kinds are degenerate, to stress the exchange.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"

namespace tessera {

// The names of all kinds: uniform, lattice, sphere, clusters, slab, planes, curve, jitter, corners. clouds.cc describes
// them.
const std::vector<std::string>& cloud_kinds();

// About n distinct points that span the space, in a random order, with ids from 0. REQUIRES: kind is one of
// cloud_kinds(), n > dimension. Throws std::invalid_argument when a thousand clouds of so few points do not span it.
std::vector<LocalPoint> make_cloud(const std::string& kind, int dimension, std::size_t n, std::uint64_t seed);
// The coordinates x, y (and z in 3D) of all points, in the layout that array_source() takes.
std::vector<double> coordinates_of(const std::vector<LocalPoint>& cloud, int dimension);

}  // namespace tessera
