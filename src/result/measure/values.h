// What the kinds of measures have in common: looks for a stop, exact volumes of a tile's cells, values as bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/measure/exact_volume.h"
#include "src/result/measure/tile_measure.h"

namespace tessera {

template <class Number>
std::vector<std::byte> as_bytes(const std::vector<Number>& numbers) {
  const auto bytes = std::as_bytes(std::span(numbers));
  return {bytes.begin(), bytes.end()};
}

// The error of a cell that is damaged.
inline Error not_oriented(const TileSource& source, std::size_t index, std::size_t cell) {
  return error(Errc::corrupt,
               source.file(index).string() + ": cell " + std::to_string(cell) + " is not positively oriented");
}

// Calls `take(cell, corners, exact)` for each cell of the tile, with its d + 1 vertices in the order of the file, and
// d! times its volume. Errors: corrupt for a cell that is not positively oriented; interrupted.
template <class Take>
Status for_each_cell(const TileSource& source, std::size_t index, const TileMesh& mesh, const std::stop_token& stop,
                     const Take& take) {
  constexpr std::size_t cells_a_look = 4096;  // between two checks for a stop
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::array<Point, 4> at;
  for (std::size_t cell = 0; cell < mesh.cell_ghost.size(); ++cell) {
    if (cell % cells_a_look == 0 && stop.stop_requested())
      return error(Errc::interrupted, "interrupted while measuring");
    for (std::size_t k = 0; k < corners; ++k)
      at[k] = mesh.points[static_cast<std::size_t>(mesh.cells[cell * corners + k])];
    const ScaledInteger exact = volume_times_factorial(std::span(at).first(corners));
    if (exact.value <= 0) return not_oriented(source, index, cell);
    take(cell, std::span(mesh.cells).subspan(cell * corners, corners), exact);
  }
  return success();
}

// The cells around some vertices of a tile.
struct Stars {
  // Around the tile's own vertices.
  explicit Stars(const TileMesh& mesh) : Stars(mesh, [&](std::size_t v) { return mesh.point_ghost[v] == 0; }) {}
  // Around the vertices for which `wanted(vertex)` is true. The tile has all cells of its own vertices alone.
  template <class Wanted>
  Stars(const TileMesh& mesh, const Wanted& wanted) {
    const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
    const auto is_wanted = [&](std::int32_t v) { return wanted(static_cast<std::size_t>(v)); };
    first.assign(mesh.points.size() + 1, 0);
    for (const std::int32_t v : mesh.cells) first[static_cast<std::size_t>(v) + 1] += is_wanted(v) ? 1 : 0;
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    around.resize(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < mesh.cells.size(); ++i)
      if (is_wanted(mesh.cells[i]))
        around[next[static_cast<std::size_t>(mesh.cells[i])]++] = static_cast<std::uint32_t>(i / corners);
  }
  std::span<const std::uint32_t> of(std::size_t vertex) const {
    return std::span(around).subspan(first[vertex], first[vertex + 1] - first[vertex]);
  }

  std::vector<std::uint32_t> first, around;
};

}  // namespace tessera
