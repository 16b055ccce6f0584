// The right answer for tests: CGAL's triangulation of all points, as a set of cells of source indices.
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

// A cell as sorted ids. infinite_id pads cells in 2D, and also stands for the infinite vertex.
using IdCell = std::array<PointId, 4>;
inline constexpr PointId infinite_id{~std::uint64_t{0}};

// The finite cells of the triangulation, sorted. Points with equal coordinates are one vertex, with the lowest id.
// Empty when the points do not span space.
std::vector<IdCell> global_delaunay(std::span<const LocalPoint> points, int dimension);
// The same with infinite cells.
std::vector<IdCell> global_delaunay_with_hull(std::span<const LocalPoint> points, int dimension);

// The main cells of all meshes, sorted. A cell that is main in two meshes is listed twice.
std::vector<IdCell> main_cells(std::span<const TileMesh> meshes);

// Describes how two sorted lists differ: "missing 4: (1 2 3 4) ...; extra 2: ...", with up to 5 cells each. "" when the
// lists are equal.
std::string difference(const std::vector<IdCell>& expected, const std::vector<IdCell>& got);

}  // namespace tessera
