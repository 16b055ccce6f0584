#include "src/terrain/dem.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/base/option.h"
#include "src/crs/crs.h"
#include "src/export/cell_filter.h"
#include "src/files/names.h"
#include "src/mesh/tile_mesh.h"
#include "src/query/on_threads.h"
#include "src/store/tile_store.h"
#include "src/terrain/blocks.h"
#include "src/terrain/cell_raster.h"
#include "src/terrain/cog_file.h"

namespace tessera {

namespace fs = std::filesystem;

namespace terrain {
namespace {

// Of the whole, drawing; the rest is compressing.
constexpr double drawing_part = 0.6;

Status check_target(const fs::path& target, bool overwrite) {
  std::string ending = target.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending != ".tif" && ending != ".tiff")
    return error(Errc::usage, target.string() + ": will be a GeoTIFF, so give a name that ends in .tif");
  std::error_code code;
  if (fs::is_directory(target, code)) return error(Errc::usage, target.string() + ": is a folder");
  if (!overwrite && fs::exists(target, code))
    return error(Errc::usage, target.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
  return success();
}

// Where in a vertex's attributes the value is.
struct Column {
  std::size_t offset = 0;
  AttributeType type = AttributeType::f64;
};

Result<Column> find_column(const fs::path& out, const Manifest& manifest, const std::string& name) {
  Column column;
  std::string names;
  for (const auto& attribute : manifest.schema) {
    column.type = attribute.type;
    if (attribute.name == name) return column;
    column.offset += size_of(attribute.type);
    names += (names.empty() ? "" : ", ") + attribute.name;
  }
  if (name == "z" && names.empty()) return error(Errc::usage, out.string() + ": its vertices have no heights");
  return error(Errc::usage, out.string() + ": its vertices have no attribute '" + name + "' for " + option("value") +
                                "; they have " + (names.empty() ? "none" : names));
}

class Drawing {
 public:
  Drawing(const fs::path& out, const Manifest& manifest, const Column& column, const Grid& grid,
          const DemOptions& options, const std::stop_token& stop, CogFile& file)
      : out_(out),
        manifest_(manifest),
        column_(column),
        row_bytes_(row_bytes(manifest.schema)),
        grid_(grid),
        options_(options),
        stop_(stop),
        file_(file),
        filter_(options.max_edge) {}

  Status run() {
    // As a mesh with attributes, and what reading takes beside it.
    std::uint64_t tile_bytes = 1 << 20;
    for (const auto& entry : manifest_.tiles) tile_bytes = std::max(tile_bytes, entry.bytes * 5 / 4);
    const std::uint64_t each = tile_bytes + 16 * sizeof(Block);
    const std::uint64_t most = std::max<std::uint64_t>(options_.memory_bytes / each, 1);
    const auto threads = static_cast<unsigned>(std::min<std::uint64_t>(
        {std::max(options_.threads, 1u), most, std::max<std::size_t>(manifest_.tiles.size(), 1)}));
    const std::uint64_t share = options_.memory_bytes / threads;
    blocks_bytes_ = std::max<std::uint64_t>(share - std::min(share, tile_bytes), 16 * sizeof(Block));
    std::atomic<bool> failed{false};
    return query::on_threads(threads, failed, [&]() -> Status {
      Blocks blocks(grid_);
      for (std::size_t i = next_++; i < manifest_.tiles.size() && !failed; i = next_++) {
        if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while drawing");
        BOOST_OUTCOME_TRYV(draw(manifest_.tiles[i], blocks));
        const std::lock_guard lock(mutex_);
        ++done_;
        if (options_.progress)
          options_.progress(drawing_part * static_cast<double>(done_) / static_cast<double>(manifest_.tiles.size()));
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
        cell[k] = {mesh.points[v], mesh.ids[v],
                   as_double(column_.type, tile.rows.data() + v * row_bytes_ + column_.offset)};
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
  Column column_;
  std::size_t row_bytes_;
  Grid grid_;
  const DemOptions& options_;
  std::stop_token stop_;
  CogFile& file_;
  exports::CellFilter filter_;
  std::uint64_t blocks_bytes_ = 0;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::uint64_t> left_out_{0};
  std::mutex mutex_;
  std::size_t done_ = 0;  // tiles
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
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  if (manifest.dimension != 2)
    return error(Errc::usage, out.string() + ": is a 3D result, which has no heights over a plane; triangulate with " +
                                  option("dim", "2"));
  BOOST_OUTCOME_TRY(column, terrain::find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRY(grid, terrain::grid_over(options.res, options.box.value_or(manifest.bounds), manifest.bounds));

  // A quarter for GDAL's blocks, the rest for tiles and what is drawn of them.
  DemOptions drawing_options = options;
  drawing_options.memory_bytes = options.memory_bytes / 4 * 3;
  BOOST_OUTCOME_TRY(file, terrain::CogFile::create(target, grid,
                                                   {.crs = manifest.crs,
                                                    .name = options.value,
                                                    .doubles = options.doubles,
                                                    .heights = options.value == "z",
                                                    .cache_bytes = options.memory_bytes / 4,
                                                    .threads = options.threads}));
  terrain::Drawing drawing(out, manifest, column, grid, drawing_options, stop, *file);
  BOOST_OUTCOME_TRYV(drawing.run());
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
