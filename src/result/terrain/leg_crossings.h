// Where a straight line in the plane meets the edges and vertices of triangles.
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
  enum class Kind : std::uint8_t { vertex, end, edge };  // where several are in one place, the first of them
  Kind kind = Kind::vertex;
  std::array<PointId, 3> ids{};  // of the vertex thrice, of the cell ascending, of the edge with the lower one twice
  Point at;
  double part = 0;  // of the line up to here, 0..1
  double value = 0;
  bool joined = false;  // with the next by a cell
};

// Of each place one, in the order of the line, exactly. REQUIRES: cells are counterclockwise and do not overlap.
std::vector<Crossing> crossings(const query::Leg& leg, std::span<const Triangle> cells);

}  // namespace tessera::terrain
