#include "src/terrain/dem.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/crs/crs.h"
#include "src/export/cell_filter.h"
#include "src/files/names.h"
#include "src/mesh/tile_mesh.h"
#include "src/query/column.h"
#include "src/query/on_threads.h"
#include "src/store/tile_store.h"
#include "src/terrain/blocks.h"
#include "src/terrain/cell_raster.h"
#include "src/terrain/cog_file.h"
#include "src/terrain/ending.h"
#include "src/terrain/tiles.h"

namespace tessera {

namespace fs = std::filesystem;

namespace terrain {
namespace {

// Of the whole, drawing; the rest is compressing.
constexpr double drawing_part = 0.6;

Status check_target(const fs::path& target, bool overwrite) {
  if (const std::string ending = ending_of(target); ending != ".tif" && ending != ".tiff")
    return error(Errc::usage, target.string() + ": will be a GeoTIFF, so give a name that ends in .tif");
  return check_free(target, overwrite);
}

class Drawing {
 public:
  Drawing(const fs::path& out, const Manifest& manifest, const query::Column& column, const Grid& grid,
          const DemOptions& options, CogFile& file)
      : out_(out),
        manifest_(manifest),
        column_(column),
        row_bytes_(row_bytes(manifest.schema)),
        grid_(grid),
        options_(options),
        file_(file),
        filter_(options.max_edge) {}

  Status run(TileQueue& tiles) {
    // As a mesh with attributes, and what reading takes beside it.
    constexpr double tile_factor = 1.25;
    constexpr std::uint64_t blocks_least = 16 * sizeof(Block);
    const unsigned threads = tiles.threads(options_.threads, options_.memory_bytes, tile_factor, blocks_least);
    const std::uint64_t share = options_.memory_bytes / threads, tile_bytes = tiles.tile_bytes(tile_factor);
    blocks_bytes_ = std::max<std::uint64_t>(share - std::min(share, tile_bytes), blocks_least);
    std::atomic<bool> failed{false};
    return query::on_threads(threads, failed, [&]() -> Status {
      Blocks blocks(grid_);
      while (!failed) {
        BOOST_OUTCOME_TRY(entry, tiles.next());
        if (entry == nullptr) break;
        BOOST_OUTCOME_TRYV(draw(*entry, blocks));
        tiles.done();
      }
      return file_.add(blocks);
    });
  }
  std::uint64_t left_out() const { return left_out_; }

 private:
  Error corrupt(TileId tile, const std::string& what) const {
    return error(Errc::corrupt, stored_tile_file(out_, tile).string() + ": " + what);
  }

  Result<StoredTile> load(const TileEntry& entry) const {
    BOOST_OUTCOME_TRY(tile, read_tile(out_, entry.tile, true));
    const TileMesh& mesh = tile.mesh;
    if (mesh.dimension != 2 || tile.schema != manifest_.schema || mesh.points.size() != entry.points ||
        mesh.cell_ghost.size() != entry.cells)
      return corrupt(entry.tile, "is not what the manifest says");
    const Bounds& bounds = manifest_.bounds;
    for (const Point& p : mesh.points)
      if (!(p.x >= bounds.lo.x && p.x <= bounds.hi.x && p.y >= bounds.lo.y && p.y <= bounds.hi.y))
        return corrupt(entry.tile, "has a vertex outside of the manifest's bounds");
    return tile;
  }

  Status draw(const TileEntry& entry, Blocks& blocks) {
    BOOST_OUTCOME_TRY(tile, load(entry));
    const TileMesh& mesh = tile.mesh;
    std::uint64_t left_out = 0;
    bool apart = true;
    for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
      if (!filter_.keeps(mesh, i)) {
        left_out += mesh.cell_ghost[i] == 0 ? 1 : 0;
        continue;
      }
      Triangle cell;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(mesh.cells[3 * i + k]);
        cell[k] = {mesh.points[v], mesh.ids[v], column_.value(tile.rows.data() + v * row_bytes_)};
      }
      for_each_pixel(grid_, cell, [&](std::int64_t column, std::int64_t row, double value) {
        apart =
            blocks.put(column, row, options_.doubles ? value : static_cast<double>(static_cast<float>(value))) && apart;
      });
      if (blocks.bytes() > blocks_bytes_) {
        BOOST_OUTCOME_TRYV(file_.add(blocks));
      }
    }
    if (!apart) return corrupt(entry.tile, "its cells overlap each other, or those of other tiles");
    left_out_ += left_out;
    return success();
  }

  const fs::path& out_;
  const Manifest& manifest_;
  query::Column column_;
  std::size_t row_bytes_;
  Grid grid_;
  const DemOptions& options_;
  CogFile& file_;
  exports::CellFilter filter_;
  std::uint64_t blocks_bytes_ = 0;
  std::atomic<std::uint64_t> left_out_{0};
};

}  // namespace
}  // namespace terrain

std::string to_json(const Dem& dem) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "dem"},       {"output", dem.path.string()}, {"width", dem.width}, {"height", dem.height},
                    {"pixels", dem.pixels}, {"left_out", dem.left_out},    {"bytes", dem.bytes}, {"note", dem.note}};
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<Dem> write_dem(const fs::path& out, const fs::path& target, const DemOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRYV(terrain::check_target(target, options.overwrite));
  if (options.max_edge && !(std::isfinite(*options.max_edge) && *options.max_edge > 0))
    return error(Errc::usage, option("max-edge") + ": must be a length, finite and above 0");
  if (options.light && options.doubles)
    return error(Errc::usage, option("hillshade", "true") + ": its pixels are bytes, whatever " + option("type"));
  if (options.light &&
      !(std::isfinite(options.light->azimuth) && options.light->altitude > 0 && options.light->altitude <= 90))
    return error(Errc::usage, option("altitude") + ": must be above 0 degrees, and 90 at most");
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  if (manifest.dimension != 2)
    return error(Errc::usage, out.string() + ": is a 3D result, which has no heights over a plane; triangulate with " +
                                  option("dim", "2"));
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRY(grid, terrain::grid_over(options.res, options.box.value_or(manifest.bounds), manifest.bounds));

  std::optional<Bounds> centres;  // which may be outside of the box, by half a pixel
  if (options.box) {
    centres.emplace();
    centres->add(Point{grid.centre(grid.column0), grid.centre(grid.row0), 0});
    centres->add(Point{grid.centre(grid.column0 + grid.width - 1), grid.centre(grid.row0 + grid.height - 1), 0});
  }
  BOOST_OUTCOME_TRY(entries, terrain::tiles_meeting(out, manifest, centres,
                                                    {.memory_bytes = options.memory_bytes / 2, .stop = stop}));
  terrain::TileQueue tiles(std::move(entries), stop, [&](double done) {
    if (options.progress) options.progress(terrain::drawing_part * done);
  });

  // A quarter for GDAL's blocks, the rest for tiles and what is drawn of them.
  DemOptions drawing_options = options;
  drawing_options.memory_bytes = options.memory_bytes / 4 * 3;
  BOOST_OUTCOME_TRY(file, terrain::CogFile::create(target, grid,
                                                   {.crs = manifest.crs,
                                                    .name = options.value,
                                                    .doubles = options.doubles,
                                                    .heights = options.value == "z" && !options.light,
                                                    .light = options.light,
                                                    .cache_bytes = options.memory_bytes / 4,
                                                    .threads = options.threads}));
  terrain::Drawing drawing(out, manifest, column, grid, drawing_options, *file);
  BOOST_OUTCOME_TRYV(drawing.run(tiles));
  BOOST_OUTCOME_TRY(bytes, file->finish([&](double done) {
    if (options.progress) options.progress(terrain::drawing_part + (1 - terrain::drawing_part) * done);
    return !stop.stop_requested();
  }));
  return Dem{.path = target,
             .width = grid.width,
             .height = grid.height,
             .pixels = file->pixels(),
             .left_out = drawing.left_out(),
             .bytes = bytes,
             .note = crs_note(manifest.crs)};
}

}  // namespace tessera
