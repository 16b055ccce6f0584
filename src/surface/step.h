// The steps by which the tiles of a result come to a surface: each is a stage of the exchange (src/exchange), so that a
// step begins when all tiles, wherever they are, have come to the end of the one before.
//
//   scales    | of each own vertex, by its edges; the first tile hears of all and finds the median
//   rays      | of own vertices; then of those that come from other tiles
//   sums      | what rays have left of facets and cells goes to their main tiles
//   arcs      | facets' main tiles tell cells' main tiles of arcs; each tile decides what it can alone
//   groups    | the first tile of some neighbours decides what they can together (groups.h)
//   districts | likewise of some groups
//   cut       | the first of all tiles decides the rest
//   triangles | cells' main tiles tell the others that hold them on which side they are
#pragma once

#include <cstdint>

namespace tessera::surface {

enum class Step : std::uint8_t { scales, rays, sums, arcs, groups, districts, cut, triangles };
inline constexpr std::uint32_t steps_count = 8;

// What is kept of a tile after a step, for later ones; and beside that, of the steps scales, rays, arcs, groups and
// districts.
enum class Kept : std::uint8_t {
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
inline constexpr std::uint32_t kept_count = 13;
constexpr Kept kept_of(Step step) { return static_cast<Kept>(step); }

}  // namespace tessera::surface
