// Clouds as the public library takes them, and its answers as sets of cells to compare.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "tessera/tessera.h"

namespace tessera::testing {

inline std::vector<double> flat(const std::vector<LocalPoint>& points, int dimension) {
  std::vector<double> coordinates;
  for (const LocalPoint& p : points) {
    for (int axis = 0; axis < dimension; ++axis) coordinates.push_back(p.at[axis]);
  }
  return coordinates;
}

// Row i gets the id i, as the library numbers them.
inline std::vector<LocalPoint> labelled(const std::vector<double>& coordinates, int dimension) {
  const auto d = static_cast<std::size_t>(dimension);
  std::vector<LocalPoint> points;
  for (std::size_t i = 0; i < coordinates.size(); i += d) {
    const double z = d == 3 ? coordinates[i + 2] : 0;
    points.push_back({.at = without_negative_zero({coordinates[i], coordinates[i + 1], z}), .id = i / d});
  }
  return points;
}

// About n points of that kind.
inline std::vector<double> cloud(const std::string& kind, int dimension, std::size_t n, std::uint64_t seed = 1) {
  return flat(make_cloud(kind, dimension, n, seed), dimension);
}

inline std::vector<IdCell> expected_cells(const std::vector<double>& coordinates, int dimension) {
  return global_delaunay(labelled(coordinates, dimension), dimension);
}

inline std::vector<IdCell> cells_of(const Delaunay& triangulation) {
  const auto corners = static_cast<std::size_t>(triangulation.dimension()) + 1;
  std::vector<IdCell> cells;
  for (std::size_t i = 0; i < triangulation.simplices().size(); i += corners) {
    IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
    for (std::size_t k = 0; k < corners; ++k) cell[k] = {static_cast<std::uint64_t>(triangulation.simplices()[i + k])};
    std::sort(cell.begin(), cell.end());
    cells.push_back(cell);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

// The main cells of all tiles: twice when a cell is main twice.
inline std::vector<IdCell> cells_of(const Triangulation& triangulation) {
  const auto corners = static_cast<std::size_t>(triangulation.dimension()) + 1;
  std::vector<IdCell> cells;
  for (std::size_t t = 0; t < triangulation.tiles(); ++t) {
    const Tile tile = triangulation.tile(t);
    for (std::size_t c = 0; c < tile.ghost().size(); ++c) {
      if (tile.ghost()[c]) continue;
      IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
      for (std::size_t k = 0; k < corners; ++k)
        cell[k] = {tile.ids()[static_cast<std::size_t>(tile.cells()[c * corners + k])]};
      std::sort(cell.begin(), cell.end());
      cells.push_back(cell);
    }
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

// What `work` throws, which must be a Failure.
template <class Work>
Failure failure_of(Work&& work) {
  try {
    work();
  } catch (const Failure& failure) {
    return failure;
  }
  return {Cause::internal, "nothing was thrown"};
}

}  // namespace tessera::testing
