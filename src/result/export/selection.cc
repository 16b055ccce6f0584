#include "src/result/export/selection.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "src/base/option.h"

namespace tessera::exports {

namespace {

std::string shortest_digits(double number) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

}  // namespace

Result<Selection> select(const MeshSource& source, bool numbers_wanted) {
  const Manifest& manifest = source.manifest;
  Selection selection;
  selection.vertices = manifest.vertices;
  selection.cells = manifest.cells;
  std::uint64_t vertices = 0, main_cells = 0;
  for (const auto& entry : manifest.tiles) {
    selection.ranges.push_back({entry.tile, entry.own_points, entry.main_cells});
    vertices += entry.own_points;
    main_cells += entry.main_cells;
  }
  if (vertices != manifest.vertices || main_cells != manifest.cells)
    return error(Errc::corrupt, source.out.string() + ": its manifest counts " + std::to_string(manifest.vertices) +
                                    " vertices and " + std::to_string(manifest.cells) +
                                    " cells, but its list of tiles counts " + std::to_string(vertices) + " and " +
                                    std::to_string(main_cells));
  if (numbers_wanted || source.filter.active()) {
    BOOST_OUTCOME_TRY(numbers, VertexNumbers::prepare(*source.tiles, source.filter, source.stop));
    selection.numbers = std::move(numbers);
  }
  if (!source.filter.active()) return selection;

  double shortest = std::numeric_limits<double>::infinity();
  selection.cells = 0;
  for (std::size_t index = 0; index < manifest.tiles.size(); ++index) {
    if (source.stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    if (source.options.progress) source.options.progress(0);  // nothing is written yet, but the callback may stop it
    BOOST_OUTCOME_TRY(tile, source.tiles->read(index, {}));
    selection.numbers.survey(tile.mesh, index);
    auto& cells = selection.ranges[index].cells;
    cells = 0;
    for (std::size_t i = 0; i < tile.mesh.cell_ghost.size(); ++i) {
      if (tile.mesh.cell_ghost[i] != 0) continue;
      shortest = std::min(shortest, longest_edge(tile.mesh, i));
      cells += source.filter.keeps(tile.mesh, i) ? 1 : 0;
    }
    selection.cells += cells;
  }
  if (selection.cells == 0 && manifest.cells > 0)
    return error(Errc::usage, source.out.string() + ": no cell is left, because each has an edge longer than " +
                                  shortest_digits(*source.options.max_edge) + "; give at least " +
                                  shortest_digits(shortest) + " as " + option("max-edge"));
  const auto used = selection.numbers.used_by_tile();
  selection.vertices = 0;
  for (std::size_t index = 0; index < used.size(); ++index) {
    selection.ranges[index].vertices = used[index];
    selection.vertices += used[index];
  }
  return selection;
}

Selection select_all(const TileMesh& cells, std::span<const TileId> tiles) {
  Selection selection{.ranges = {}, .vertices = cells.points.size(), .cells = tiles.size(), .numbers = {}};
  const std::size_t corners = static_cast<std::size_t>(cells.dimension) + 1;
  std::uint64_t used = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (i == 0 || tiles[i] != tiles[i - 1]) selection.ranges.push_back({tiles[i], 0, 0});
    TileRange& range = selection.ranges.back();
    ++range.cells;
    for (std::size_t k = 0; k < corners; ++k) {
      if (static_cast<std::uint64_t>(cells.cells[i * corners + k]) < used) continue;
      ++used;
      ++range.vertices;
    }
  }
  return selection;
}

}  // namespace tessera::exports
