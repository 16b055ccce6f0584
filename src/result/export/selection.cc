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

// The limits that leave at least one cell, as far as they are known.
struct LeastSizes {
  double edge = std::numeric_limits<double>::infinity(), radius = edge;
};

Error none_left(const MeshSource& source, const LeastSizes& least) {
  const auto& edge = source.options.max_edge;
  const auto& radius = source.options.max_radius;
  const std::string begin = source.out.string() + ": no cell is left, because each has ";
  const std::string longer = edge ? "an edge longer than " + shortest_digits(*edge) : "";
  const std::string larger = radius ? "a circumradius larger than " + shortest_digits(*radius) : "";
  if (edge && radius)
    return error(Errc::usage, begin + longer + " or " + larger + "; give a larger " + option("max-edge") + " or " +
                                  option("max-radius"));
  return error(Errc::usage, begin + longer + larger + "; give at least " +
                                shortest_digits(edge ? least.edge : least.radius) + " as " +
                                option(edge ? "max-edge" : "max-radius"));
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
    BOOST_OUTCOME_TRY(numbers,
                      VertexNumbers::prepare(*source.tiles, source.filter, !source.format.corners, source.stop));
    selection.numbers = std::move(numbers);
  }
  const auto add_images = [&] {
    const auto& images = selection.numbers.images_by_tile();
    for (std::size_t index = 0; index < images.size(); ++index) {
      selection.ranges[index].vertices += images[index];
      selection.vertices += images[index];
    }
  };
  if (!source.filter.active()) {
    add_images();
    return selection;
  }

  LeastSizes least;
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
      least.edge = std::min(least.edge, longest_edge(tile.mesh, i));
      if (source.filter.keeps(tile.mesh, i)) {
        ++cells;
      } else if (source.options.max_radius && cells + selection.cells == 0) {
        least.radius = std::min(least.radius, circumradius_of(tile.mesh, i));
      }
    }
    selection.cells += cells;
  }
  if (selection.cells == 0 && manifest.cells > 0) return none_left(source, least);
  const auto used = selection.numbers.used_by_tile();
  selection.vertices = 0;
  for (std::size_t index = 0; index < used.size(); ++index) {
    selection.ranges[index].vertices = used[index];
    selection.vertices += used[index];
  }
  add_images();
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
