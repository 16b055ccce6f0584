#include "src/result/terrain/drawing.h"

#include <algorithm>
#include <string>

#include "src/base/files/names.h"
#include "src/base/on_threads.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/terrain/cell_raster.h"

namespace tessera::terrain {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t cells_a_look = 4096;  // between two checks for a stop

Error corrupt(const fs::path& file, const std::string& what) {
  return error(Errc::corrupt, file.string() + ": " + what);
}

}  // namespace

Status Drawing::run(const StoredTile& cells) {
  Blocks blocks(grid_);
  BOOST_OUTCOME_TRYV(draw(cells, out_, blocks));
  return take_(blocks);
}

Status Drawing::run(TileQueue& tiles) {
  // A tile is a mesh with attributes, and reading needs some more.
  constexpr double tile_factor = 1.25;
  const unsigned threads = tiles.threads(options_.threads, options_.memory_bytes, tile_factor, blocks_least);
  const std::uint64_t share = options_.memory_bytes / threads, tile_bytes = tiles.tile_bytes(tile_factor);
  blocks_bytes_ = std::max<std::uint64_t>(share - std::min(share, tile_bytes), blocks_least);
  std::atomic<bool> failed{false};
  return on_threads(threads, failed, [&]() -> Status {
    Blocks blocks(grid_);
    while (!failed) {
      BOOST_OUTCOME_TRY(index, tiles.next());
      if (!index) break;
      BOOST_OUTCOME_TRYV(draw(tiles.source(), *index, blocks));
      tiles.done();
    }
    return take_(blocks);
  });
}

Status Drawing::draw(const TileSource& source, std::size_t index, Blocks& blocks) {
  BOOST_OUTCOME_TRY(tile, source.read(index, {.rows = true}));
  const Bounds& bounds = manifest_.bounds;
  for (const Point& p : tile.mesh.points)
    if (!(p.x >= bounds.lo.x && p.x <= bounds.hi.x && p.y >= bounds.lo.y && p.y <= bounds.hi.y))
      return corrupt(source.file(index), "has a vertex outside of the manifest's bounds");
  return draw(tile, source.file(index), blocks);
}

Status Drawing::draw(const StoredTile& tile, const fs::path& from, Blocks& blocks) {
  const TileMesh& mesh = tile.mesh;
  std::uint64_t left_out = 0;
  bool apart = true;
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (i % cells_a_look == 0 && stop_.stop_requested()) return error(Errc::interrupted, "interrupted while drawing");
    if (!filter_.keeps(mesh, i)) {
      left_out += mesh.cell_ghost[i] == 0 ? 1 : 0;
      continue;
    }
    Triangle cell;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh.cells[3 * i + k]);
      cell[k] = {mesh.points[v], mesh.ids[v], column_.value(tile.rows.data() + v * row_bytes_)};
    }
    const auto put = [&](std::int64_t column, std::int64_t row, double value) {
      apart =
          blocks.put(column, row, options_.doubles ? value : static_cast<double>(static_cast<float>(value))) && apart;
    };
    // The parts bound the pixels in memory, also for a cell that covers most of a large raster, and let a stop take
    // effect.
    BOOST_OUTCOME_TRYV(for_each_part(grid_, cell, [&](const Grid& part) -> Status {
      if (part.width * part.height != grid_.width * grid_.height && stop_.stop_requested())
        return error(Errc::interrupted, "interrupted while drawing");
      for_each_pixel(part, cell, put);
      if (blocks.bytes() > blocks_bytes_) {
        BOOST_OUTCOME_TRYV(take_(blocks));
      }
      return success();
    }));
  }
  if (!apart) return corrupt(from, "its cells overlap each other, or those of other tiles");
  left_out_ += left_out;
  return success();
}

}  // namespace tessera::terrain
