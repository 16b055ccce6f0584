// The right answer for periodic clouds: one triangulation of many copies (docs/periodic-design.md).
#pragma once

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

// Distinct points between 0 and the period, such that shifts by a period do not round.
struct PeriodicCloud {
  int dimension = 3;
  Period period;
  std::vector<LocalPoint> points;
};

// A cell up to shifts by periods: sorted vertices, of which the first has the offset 0. Padded in 2D.
using PeriodicCell = std::array<std::pair<PointId, PeriodOffset>, 4>;

// The cells of the cloud, sorted, from a triangulation of `copies` copies along each axis that has a period. Three are
// enough. Empty when the points do not span space. REQUIRES: `copies` is odd.
std::vector<PeriodicCell> periodic_delaunay(const PeriodicCloud& cloud, int copies = 3);
// The main cells of all meshes, sorted. A cell that is main in two meshes is listed twice.
std::vector<PeriodicCell> periodic_main_cells(std::span<const TileMesh> meshes);

// Describes how two sorted lists differ, with up to 5 cells each. "" when the lists are equal.
std::string difference(const std::vector<PeriodicCell>& expected, const std::vector<PeriodicCell>& got);

// Makes a cloud periodic along the axes with a period: moves its points between 0 and the period. Of points that are
// equal then the first stays. Coordinates are rounded down to multiples of a small power of two.
PeriodicCloud wrapped(int dimension, std::span<const LocalPoint> points, const Period& period);

}  // namespace tessera
