// Follows rays through the cells of a tile, exactly (line.h), and adds what they say to arcs and excess.
//
// From a vertex towards its sensor: a facet that is crossed is no surface, the less so the farther it is from the
// vertex; where the ray ends, at the sensor or before, the cell is outside. Behind the vertex the cell that its scale
// reaches is inside.
//
// That a facet is no surface is an arc from the farther cell to the nearer one. Arcs have less weight the nearer they
// are, so the flow from the ray's end can go along all of them at once; it does so here, already: excess then stands
// next to the surface, and a cut finds its way in a few steps. What tiles add up are the arcs and the excess that are
// left (docs/surfaces.md).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/surface/records.h"
#include "src/surface/surface_tile.h"

namespace tessera::surface {

class RayCaster {
 public:
  // `tile` outlives this, and has weights. `cells`: of the whole triangulation. A ray comes through each once at most:
  // damaged neighbours cannot send it round for ever.
  RayCaster(SurfaceTile& tile, const Energy& energy, std::uint64_t cells)
      : tile_(tile), energy_(energy), cells_(cells) {}

  // Both rays of an own vertex. `vote`: of what is behind it, full_vote or less. REQUIRES: the sensor is elsewhere.
  Status cast(std::int32_t vertex, const Point& sensor, double sigma, std::uint32_t vote);
  // A ray that comes from another tile.
  Status go_on(const RayRecord& ray);

  // Rays that go on elsewhere, each with a tile that holds the cell and knows its neighbour; forgets them.
  std::vector<std::pair<TileId, RayRecord>> take_leaving() { return std::exchange(leaving_, {}); }
  std::uint64_t steps() const { return steps_; }

 private:
  Status follow(RayRecord ray, std::int32_t cell, std::size_t exit);
  void end(const RayRecord& ray, std::int32_t cell);
  Result<std::size_t> exit_of(const RayRecord& ray, std::int32_t cell, std::array<std::int32_t, 3>& facet,
                              std::size_t apex) const;

  SurfaceTile& tile_;
  const Energy& energy_;
  std::uint64_t cells_;
  std::vector<std::pair<TileId, RayRecord>> leaving_;
  std::uint64_t steps_ = 0;
};

}  // namespace tessera::surface
