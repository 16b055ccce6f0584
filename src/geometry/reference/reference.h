// The right answer: CGAL's triangulation of all points, as a set of cells of source indices.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera {

// Sorted ids; 2D cells are padded with infinite_id, which also stands for the infinite vertex.
using IdCell = std::array<PointId, 4>;
inline constexpr PointId infinite_id{~std::uint64_t{0}};

// Finite cells, sorted. Equal points become one vertex with the lowest id. Empty when the points span no volume.
std::vector<IdCell> global_delaunay(std::span<const LocalPoint> points, int dimension);
// Infinite ones too.
std::vector<IdCell> global_delaunay_with_hull(std::span<const LocalPoint> points, int dimension);

// The main cells of all meshes, sorted; a cell that is main twice is there twice.
std::vector<IdCell> main_cells(std::span<const TileMesh> meshes);

// What differs, for people: "missing (1 2 3 4), 3 more; extra ..." or "" when equal.
std::string difference(const std::vector<IdCell>& expected, const std::vector<IdCell>& got);

}  // namespace tessera
