// Finds where a straight line in the plane meets the edges and vertices of triangles.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/result/query/area.h"
#include "src/result/terrain/cell_raster.h"

namespace tessera::terrain {

struct Crossing {
  enum class Kind : std::uint8_t { vertex, end, edge };  // of several in one place, the first kind counts
  Kind kind = Kind::vertex;
  std::array<PointId, 3> ids{};  // vertex: its id three times; cell: ascending; edge: the lower id twice
  Point at;
  double fraction = 0;  // of the line up to here, 0..1
  double value = 0;
  bool joined = false;  // a cell joins it with the next crossing
};

// Returns one crossing for each place, in the exact order along the line. REQUIRES: cells are counterclockwise and do
// not overlap.
std::vector<Crossing> crossings(const query::Leg& leg, std::span<const Triangle> cells);

}  // namespace tessera::terrain
