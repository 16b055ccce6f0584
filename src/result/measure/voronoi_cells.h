// The Voronoi cells of a tile's own vertices: what is known of each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera::voronoi {

struct VoronoiCell {
  double volume = 0, surface = 0;    // in 2D area and length of the boundary; infinite on the hull
  std::array<double, 3> centroid{};  // NaN on the hull
  std::uint32_t neighbours = 0;
};

using TakeCell = std::function<void(std::size_t vertex, const VoronoiCell& cell)>;

// Calls `take` once for each own vertex. The values depend on the cells around the vertex alone, not on how these are
// stored; the relative error of an area is at most 1e-15, that of a volume 1e-13. Where not all cells around a vertex
// are known, values are NaN. REQUIRES: the mesh has neighbours, and its cells are positively oriented. Error
// interrupted.
Status planar_cells(const TileMesh& mesh, const std::stop_token& stop, const TakeCell& take);
Status space_cells(const TileMesh& mesh, const std::stop_token& stop, const TakeCell& take);

// How the cell of a vertex ends: at other cells, or on the hull; or not all of it is known.
enum class Border : std::uint8_t { none, hull, unknown };

// A cell that has no volume.
VoronoiCell open_cell(Border border, std::uint32_t neighbours);

// How many vertices have a cell with this one. `star` has all cells of the vertex.
std::uint32_t count_neighbours(const TileMesh& mesh, std::size_t vertex, std::span<const std::uint32_t> star);

// Error interrupted, if a stop is requested. `step` counts; only now and then there is a look.
inline Status go_on(const std::stop_token& stop, std::size_t step) {
  constexpr std::size_t steps_a_look = 4096;
  if (step % steps_a_look != 0 || !stop.stop_requested()) return success();
  return error(Errc::interrupted, "interrupted while measuring");
}

}  // namespace tessera::voronoi
