// The steps by which the tiles of a result make a surface. Each step is a stage of the exchange (src/exchange), so a
// step begins when all tiles, on whichever node, have finished the step before.
//
//   scales    | each tile finds the scales of its vertices from their edges; the first tile finds the median of all
//   rays      | each tile casts the rays of its vertices, and continues rays that come from other tiles
//   sums      | what rays have left on facets and cells goes to their main tiles
//   arcs      | facets' main tiles send arcs to cells' main tiles; each tile decides what it can alone
//   groups    | the first tile of some neighbours decides what these can decide together (groups.h)
//   districts | the same for some groups
//   cut       | the first of all tiles decides the rest
//   triangles | cells' main tiles tell the other tiles that hold a cell on which side it is
#pragma once

#include <cstdint>

namespace tessera::surface {

enum class SurfaceStageId : std::uint8_t { scales, rays, sums, arcs, groups, districts, cut, triangles };
inline constexpr std::uint32_t steps_count = 8;

// What is kept of a tile for later steps: one kind for each step, then further kinds of the steps scales, rays, arcs,
// groups and districts.
enum class StepOutput : std::uint8_t {
  scales,
  rays,
  sums,
  arcs,
  groups,
  districts,
  cut,
  triangles,
  own_scales,
  ray_counts,
  kernel,
  group_kernel,
  district_kernel
};
inline constexpr std::uint32_t outputs_count = 13;
constexpr StepOutput output_of(SurfaceStageId step) { return static_cast<StepOutput>(step); }

}  // namespace tessera::surface
