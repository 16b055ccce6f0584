#include "src/terrain/dem.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cmath>
#include <functional>
#include <limits>
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
constexpr std::size_t cells_a_look = 4096;  // at whether to stop

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

// Takes the pixels that were drawn. Called by several threads.
using Take = std::function<Status(Blocks&)>;

class Drawing {
 public:
  Drawing(const fs::path& out, const Manifest& manifest, const Column& column, const Grid& grid,
          const DemOptions& options, const std::stop_token& stop, Take take)
      : out_(out),
        manifest_(manifest),
        column_(column),
        row_bytes_(row_bytes(manifest.schema)),
        grid_(grid),
        options_(options),
        stop_(stop),
        take_(std::move(take)),
        filter_(options.max_edge) {}

  // Of cells that are in memory, all that may have a pixel.
  Status run(const StoredTile& cells) {
    Blocks blocks(grid_);
    blocks_bytes_ = std::max<std::uint64_t>(options_.memory_bytes, 16 * sizeof(Block));
    BOOST_OUTCOME_TRYV(draw(cells, out_, blocks));
    return take_(blocks);
  }
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
      return take_(blocks);
    });
  }
  std::uint64_t left_out() const { return left_out_; }

 private:
  static Error corrupt(const fs::path& file, const std::string& what) {
    return error(Errc::corrupt, file.string() + ": " + what);
  }

  Result<StoredTile> load(const TileEntry& entry) const {
    BOOST_OUTCOME_TRY(tile, read_tile(out_, entry.tile, true));
    const TileMesh& mesh = tile.mesh;
    if (mesh.dimension != 2 || tile.schema != manifest_.schema || mesh.points.size() != entry.points ||
        mesh.cell_ghost.size() != entry.cells)
      return corrupt(stored_tile_file(out_, entry.tile), "is not what the manifest says");
    const Bounds& bounds = manifest_.bounds;
    for (const Point& p : mesh.points)
      if (!(p.x >= bounds.lo.x && p.x <= bounds.hi.x && p.y >= bounds.lo.y && p.y <= bounds.hi.y))
        return corrupt(stored_tile_file(out_, entry.tile), "has a vertex outside of the manifest's bounds");
    return tile;
  }

  Status draw(const TileEntry& entry, Blocks& blocks) {
    BOOST_OUTCOME_TRY(tile, load(entry));
    return draw(tile, stored_tile_file(out_, entry.tile), blocks);
  }

  // `from`: whose cells they are, for errors.
  Status draw(const StoredTile& tile, const fs::path& from, Blocks& blocks) {
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
        cell[k] = {mesh.points[v], mesh.ids[v],
                   as_double(column_.type, tile.rows.data() + v * row_bytes_ + column_.offset)};
      }
      for_each_pixel(grid_, cell, [&](std::int64_t column, std::int64_t row, double value) {
        apart =
            blocks.put(column, row, options_.doubles ? value : static_cast<double>(static_cast<float>(value))) && apart;
      });
      if (blocks.bytes() > blocks_bytes_) {
        BOOST_OUTCOME_TRYV(take_(blocks));
      }
    }
    if (!apart) return corrupt(from, "its cells overlap each other, or those of other tiles");
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
  Take take_;
  exports::CellFilter filter_;
  std::uint64_t blocks_bytes_ = 0;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::uint64_t> left_out_{0};
  std::mutex mutex_;
  std::size_t done_ = 0;  // tiles
};

// What a raster of this result will be; errors: those of write_dem() before anything is written.
struct Asked {
  Manifest manifest;
  Column column;
  Grid grid;
};

Result<Asked> read_request(const fs::path& out, Manifest manifest, const DemOptions& options) {
  if (options.max_edge && !(std::isfinite(*options.max_edge) && *options.max_edge > 0))
    return error(Errc::usage, option("max-edge") + ": must be a length, finite and above 0");
  if (manifest.dimension != 2)
    return error(Errc::usage, out.string() + ": is a 3D result, which has no heights over a plane; triangulate with " +
                                  option("dim", "2"));
  BOOST_OUTCOME_TRY(column, find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRY(grid, grid_over(options.res, options.box.value_or(manifest.bounds), manifest.bounds));
  return Asked{std::move(manifest), column, grid};
}

}  // namespace
}  // namespace terrain

std::string to_json(const Dem& dem) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "dem"},       {"output", dem.path.string()}, {"width", dem.width}, {"height", dem.height},
                    {"pixels", dem.pixels}, {"left_out", dem.left_out},    {"bytes", dem.bytes}, {"note", dem.note}};
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

namespace {

// `cells`: those that may have a pixel; null: they are read.
Result<Dem> write(const fs::path& out, Manifest read, const StoredTile* cells, const fs::path& target,
                  const DemOptions& options, const std::stop_token& stop) {
  BOOST_OUTCOME_TRYV(terrain::check_target(target, options.overwrite));
  BOOST_OUTCOME_TRY(asked, terrain::read_request(out, std::move(read), options));
  const auto& [manifest, column, grid] = asked;

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
  terrain::Drawing drawing(out, manifest, column, grid, drawing_options, stop,
                           [&](terrain::Blocks& blocks) { return file->add(blocks); });
  BOOST_OUTCOME_TRYV(cells ? drawing.run(*cells) : drawing.run());
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

}  // namespace

Result<Dem> write_dem(const fs::path& out, const fs::path& target, const DemOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRYV(terrain::check_target(target, options.overwrite));
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  return write(out, std::move(manifest), nullptr, target, options, stop);
}

Result<Dem> write_dem_of(const fs::path& out, const Manifest& manifest, const StoredTile& cells, const fs::path& target,
                         const DemOptions& options, std::stop_token stop) {
  return write(out, manifest, &cells, target, options, stop);
}

Result<DemArray> draw_dem(const fs::path& out, const DemOptions& options, std::uint64_t pixels_max,
                          std::stop_token stop) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  BOOST_OUTCOME_TRY(asked, terrain::read_request(out, std::move(manifest), options));
  const terrain::Grid& grid = asked.grid;
  const auto width = static_cast<std::uint64_t>(grid.width), height = static_cast<std::uint64_t>(grid.height);
  if (width > pixels_max / height)
    return error(Errc::memory, out.string() + ": the raster has " + std::to_string(width) + " x " +
                                   std::to_string(height) + " pixels, more than " + std::to_string(pixels_max) + ": " +
                                   option("res") + " must be larger, or " + option("bbox") + " smaller");
  DemArray array{.width = grid.width,
                 .height = grid.height,
                 .left = grid.left(),
                 .top = grid.top(),
                 .values = std::vector<double>(width * height, std::numeric_limits<double>::quiet_NaN())};
  std::mutex mutex;
  const auto take = [&](terrain::Blocks& blocks) -> Status {
    const std::lock_guard lock(mutex);
    bool apart = true;
    blocks.take([&](std::int64_t x, std::int64_t y, const terrain::Block& block) {
      const std::int64_t columns = std::min(terrain::block_side, grid.width - x);
      const std::int64_t lines = std::min(terrain::block_side, grid.height - y);
      for (std::int64_t line = 0; line < lines; ++line)
        for (std::int64_t column = 0; column < columns; ++column) {
          const double value = block.pixels[line * terrain::block_side + column];
          if (std::isnan(value)) continue;
          double& pixel = array.values[static_cast<std::size_t>((y + line) * grid.width + x + column)];
          apart = apart && std::isnan(pixel);
          pixel = value;
          ++array.pixels;
        }
    });
    return apart ? Status(success()) : error(Errc::corrupt, out.string() + ": cells of its tiles overlap each other");
  };
  terrain::Drawing drawing(out, asked.manifest, asked.column, grid, options, stop, take);
  BOOST_OUTCOME_TRYV(drawing.run());
  array.left_out = drawing.left_out();
  return array;
}

}  // namespace tessera
