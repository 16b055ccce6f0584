// Follows rays through the cells of a tile, exactly (line.h), and adds their votes to arcs and excess.
//
// From a vertex towards its sensor: a facet that is crossed is no surface; its weight grows with its distance from the
// vertex. Where the ray ends, at the sensor or before, the cell is outside. Behind the vertex, the cell at the distance
// of its scale is inside.
//
// A vote that a facet is no surface is an arc from the farther cell to the nearer cell. The nearer arcs are to the
// vertex, the less weight they have, so flow from the ray's end can go along all of them at once. The code lets it flow
// here already: then excess stands next to the surface, and a cut needs only a few steps. Tiles add up the arcs and the
// excess that are left (docs/surfaces.md).
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
  // `tile` outlives this object, and has weights. `cells`: of the whole triangulation. A ray passes each cell at most
  // once, so this bounds its steps: damaged neighbours cannot send it round for ever.
  RayCaster(SurfaceTile& tile, const Energy& energy, std::uint64_t cells)
      : tile_(tile), energy_(energy), cells_(cells) {}

  // Follows both rays of an own vertex. `vote`: of the ray behind the vertex, at most full_vote. REQUIRES: the sensor
  // is not at the vertex.
  Status cast(std::int32_t vertex, const Point& sensor, double sigma, std::uint32_t vote);
  // Follows a ray that comes from another tile.
  Status go_on(const RayRecord& ray);

  // Returns the rays that continue elsewhere, each with a tile that holds the cell and knows its neighbour, and forgets
  // them.
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
