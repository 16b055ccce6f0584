// What the kinds of measures have in common: looks for a stop, exact volumes of a tile's cells, values as bytes.
#pragma once

#include <array>
#include <cstddef>
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

// Calls `take(cell, corners, exact)` for each cell of the tile, with its d + 1 vertices in the order of the file, and
// d! times its volume. Errors: those of TileMeasure::of().
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
    if (exact.value <= 0)
      return error(Errc::corrupt,
                   source.file(index).string() + ": cell " + std::to_string(cell) + " is not positively oriented");
    take(cell, std::span(mesh.cells).subspan(cell * corners, corners), exact);
  }
  return success();
}

}  // namespace tessera
