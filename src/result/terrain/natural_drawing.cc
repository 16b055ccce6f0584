#include "src/result/terrain/natural_drawing.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "src/base/on_threads.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/terrain/cell_raster.h"
#include "src/result/terrain/natural_cells.h"
#include "src/result/terrain/natural_value.h"

namespace tessera::terrain {

namespace {

constexpr std::size_t cells_a_look = 4096;  // between two checks for a stop

// The bytes of a tile in memory by those of its file: a mesh with attributes, what searches need, and circles.
constexpr double tile_factor = 2.25;

}  // namespace

// What one thread draws.
class NaturalDrawing::Thread {
 public:
  Thread(NaturalDrawing& drawing, const TileSource& source, query::TileCache& cache)
      : drawing_(drawing),
        source_(source),
        walker_(cache, source.manifest(), true),
        all_(walker_, drawing.column_, source.manifest().cells),
        all_fast_(all_, drawing.method_),
        blocks_(drawing.grid_) {}

  Status draw(std::size_t index) {
    BOOST_OUTCOME_TRY(tile, walker_.tile(source_.entry(index).tile));
    BOOST_OUTCOME_TRYV(check_bounds(index, *tile));
    CellsOfTile own(*tile, drawing_.column_);
    NaturalValue<double, CellsOfTile> fast(own, drawing_.method_);
    const TileMesh& mesh = tile->mesh();
    std::uint64_t left_out = 0;
    apart_ = true;
    failed_.reset();
    for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
      if (i % cells_a_look == 0 && drawing_.stop_.stop_requested()) return interrupted();
      if (!drawing_.filter_.keeps(mesh, i)) {
        left_out += mesh.cell_ghost[i] == 0 ? 1 : 0;
        continue;
      }
      BOOST_OUTCOME_TRYV(draw_cell(*tile, static_cast<std::int32_t>(i), own, fast));
    }
    if (!apart_)
      return error(Errc::corrupt,
                   source_.file(index).string() + ": its cells overlap each other, or those of other tiles");
    drawing_.left_out_ += left_out;
    walker_.keep_only(nullptr);
    return success();
  }

  Status finish() {
    drawing_.unknown_ += unknown_;
    return drawing_.take_(blocks_);
  }

 private:
  static Error interrupted() { return error(Errc::interrupted, "interrupted while drawing"); }

  Status check_bounds(std::size_t index, const query::QueryTile& tile) const {
    const Bounds& bounds = source_.manifest().bounds;
    for (const Point& p : tile.mesh().points)
      if (!(p.x >= bounds.lo.x && p.x <= bounds.hi.x && p.y >= bounds.lo.y && p.y <= bounds.hi.y))
        return error(Errc::corrupt, source_.file(index).string() + ": has a vertex outside of the manifest's bounds");
    return success();
  }

  Status draw_cell(const query::QueryTile& tile, std::int32_t cell, CellsOfTile& own,
                   NaturalValue<double, CellsOfTile>& fast) {
    Triangle corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = {own.point(cell, k), tile.id_of(tile.vertex(cell, k)), own.value(cell, k)};
    std::size_t pixels = 0;
    const auto put = [&](std::int64_t column, std::int64_t row, const Point& centre) {
      if (failed_) return;
      // A zone may have many cells, and a cell many pixels.
      if (++pixels % cells_a_look == 0 && drawing_.stop_.stop_requested()) failed_ = interrupted();
      const double value = value_of(corners, {&tile, cell}, centre, own, fast);
      apart_ = blocks_.put(column, row, drawing_.options_.doubles ? value : static_cast<float>(value)) && apart_;
    };
    return for_each_part(drawing_.grid_, corners, [&](const Grid& part) -> Status {
      for_each_centre(part, corners, put);
      if (failed_) return *failed_;
      if (blocks_.bytes() > drawing_.blocks_bytes_) {
        BOOST_OUTCOME_TRYV(drawing_.take_(blocks_));
      }
      return success();
    });
  }

  // NaN: the pixel has no value.
  double value_of(const Triangle& corners, const query::CellRef& cell, const Point& q, CellsOfTile& own,
                  NaturalValue<double, CellsOfTile>& fast) {
    for (const Corner& corner : corners)
      if (corner.at.x == q.x && corner.at.y == q.y) return corner.value;
    double value = 0;
    PixelState state = natural_value(own, fast, drawing_.method_, cell.cell, q, value);
    if (state == PixelState::failed) failed_ = own.error();
    if (state == PixelState::unknown) {
      walker_.keep_only(cell.tile);
      state = natural_value(all_, all_fast_, drawing_.method_, cell, q, value);
      if (state == PixelState::failed) failed_ = all_.error();
      unknown_ += state == PixelState::unknown ? 1 : 0;
    }
    if (state == PixelState::found) return value;
    if (state == PixelState::on_hull || state == PixelState::unsure) return value_at(by_id(corners), q);
    return std::numeric_limits<double>::quiet_NaN();
  }

  NaturalDrawing& drawing_;
  const TileSource& source_;
  query::Walker walker_;
  CellsOfTiles all_;
  NaturalValue<double, CellsOfTiles> all_fast_;
  Blocks blocks_;
  bool apart_ = true;
  std::optional<Error> failed_;
  std::uint64_t unknown_ = 0;
};

NaturalDrawing::NaturalDrawing(const query::Column& column, const Grid& grid, const DrawingOptions& options,
                               DemMethod method, std::stop_token stop, Consumer take)
    : column_(column),
      grid_(grid),
      options_(options),
      method_(method),
      stop_(std::move(stop)),
      take_(std::move(take)),
      filter_({options.max_edge, options.max_radius}) {}

Status NaturalDrawing::run(TileQueue& tiles) {
  constexpr std::uint64_t blocks_least = 16 * sizeof(Block);
  const unsigned threads = tiles.threads(options_.threads, options_.memory_bytes, tile_factor, blocks_least);
  const std::uint64_t share = options_.memory_bytes / threads, tile_bytes = tiles.tile_bytes(tile_factor);
  const std::uint64_t rest = share - std::min(share, tile_bytes);
  blocks_bytes_ = std::max<std::uint64_t>(rest / 2, blocks_least);
  // Tiles that are in use count as kept.
  query::TileCache cache(tiles.source(), threads * (tile_bytes + rest / 2));
  std::atomic<bool> failed{false};
  return on_threads(threads, failed, [&]() -> Status {
    Thread thread(*this, tiles.source(), cache);
    while (!failed) {
      BOOST_OUTCOME_TRY(index, tiles.next());
      if (!index) break;
      BOOST_OUTCOME_TRYV(thread.draw(*index));
      tiles.done();
    }
    return thread.finish();
  });
}

}  // namespace tessera::terrain
