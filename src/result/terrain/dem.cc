#include "src/result/terrain/dem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/export/ending.h"
#include "src/result/query/column.h"
#include "src/result/store/digest.h"
#include "src/result/store/stamp.h"
#include "src/result/store/tile_store.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/cog_file.h"
#include "src/result/terrain/drawing.h"
#include "src/result/terrain/hillshade.h"
#include "src/result/terrain/natural_drawing.h"
#include "src/result/terrain/tiles.h"

namespace tessera {

namespace fs = std::filesystem;

namespace terrain {
namespace {

// The fraction of the progress for drawing; the rest is for compressing.
constexpr double drawing_part = 0.6;

// The raster of this result as it will be. Errors: those of write_dem() before anything is written.
struct Asked {
  Manifest manifest;
  query::Column column;
  Grid grid;
};

Result<Asked> read_request(const fs::path& out, Manifest manifest, const DemOptions& options) {
  BOOST_OUTCOME_TRYV(check_surface(out, manifest, {options.max_edge, options.max_radius}));
  if (options.light && options.doubles)
    return error(Errc::usage, option("hillshade", "true") + ": a shaded raster has pixels of bytes, so " +
                                  option("type") + " cannot be given with it");
  if (options.light) {
    BOOST_OUTCOME_TRYV(check_light(*options.light));
  }
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  BOOST_OUTCOME_TRY(grid, grid_over(options.res, options.box.value_or(manifest.bounds), manifest.bounds));
  BOOST_OUTCOME_TRYV(check_meets(manifest, options.box));
  return Asked{std::move(manifest), column, grid};
}

DrawingOptions drawing_options(const DemOptions& options, std::uint64_t memory_bytes) {
  return {.max_edge = options.max_edge,
          .max_radius = options.max_radius,
          .doubles = options.doubles,
          .memory_bytes = memory_bytes,
          .threads = options.threads};
}

// The tiles with cells that may have a pixel.
auto tiles_with_pixels(const Asked& asked, const TileSource& source, const DemOptions& options,
                       const std::stop_token& stop) {
  std::optional<Bounds> centres;  // the centres may be outside of the box, by half a pixel
  if (const Grid& grid = asked.grid; options.box) {
    centres.emplace();
    centres->add(Point{grid.centre(grid.column0), grid.centre(grid.row0), 0});
    centres->add(Point{grid.centre(grid.column0 + grid.width - 1), grid.centre(grid.row0 + grid.height - 1), 0});
  }
  return tiles_meeting(source, centres, {.memory_bytes = options.memory_bytes / 2, .stop = stop});
}

}  // namespace
}  // namespace terrain

Status check_light(const Light& light) {
  if (!std::isfinite(light.azimuth))
    return error(Errc::usage, option("azimuth") + ": must be a finite number of degrees");
  if (!(light.altitude > 0 && light.altitude <= 90))
    return error(Errc::usage, option("altitude") + ": must be above 0 degrees, and 90 at most");
  return success();
}

std::string to_json(const Dem& dem) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "dem"},       {"output", dem.path.string()}, {"width", dem.width}, {"height", dem.height},
                    {"pixels", dem.pixels}, {"left_out", dem.left_out},    {"bytes", dem.bytes}, {"note", dem.note}};
  return json_text(object);
}

// Draws and writes a raster, from the first pixel to the last.
class DemMaker::Impl {
 public:
  static Result<std::unique_ptr<Impl>> begin(const fs::path& out, Manifest read, const fs::path& target,
                                             const DemOptions& options, const std::stop_token& stop) {
    BOOST_OUTCOME_TRYV(check_dem_target(target, options.overwrite));
    BOOST_OUTCOME_TRY(asked, terrain::read_request(out, std::move(read), options));
    // A quarter of the memory is for GDAL's blocks, the rest for tiles and what is drawn of them.
    BOOST_OUTCOME_TRY(file, terrain::CogFile::create(target, asked.grid,
                                                     {.crs = crs_or_none(asked.manifest.crs),
                                                      .name = options.value,
                                                      .doubles = options.doubles,
                                                      .heights = options.value == "z" && !options.light,
                                                      .light = options.light,
                                                      .cache_bytes = options.memory_bytes / 4,
                                                      .threads = options.threads,
                                                      .metadata = metadata_of(stamp_of(asked.manifest))}));
    return std::unique_ptr<Impl>(new Impl(out, std::move(asked), target, options, stop, std::move(file)));
  }

  // REQUIRES: the method is linear.
  Status draw(const StoredTile& cells) { return drawing_.run(cells); }
  // The same with a tile of a result that is being made: the digest of the result is the sum of those of its tiles.
  Status draw_new(const StoredTile& tile) {
    const Digest digest = digest_of(tile.mesh);
    {
      const std::lock_guard lock(mutex_);
      digest_ = digest_.value_or(Digest{});
      *digest_ += digest;
    }
    return draw(tile);
  }
  Status draw(const TileSource& source) {
    BOOST_OUTCOME_TRY(entries, terrain::tiles_with_pixels(asked_, source, options_, stop_));
    TileQueue tiles(source, std::move(entries), stop_, [&](double done) {
      if (options_.progress) options_.progress(terrain::drawing_part * done);
    });
    return options_.method == DemMethod::linear ? drawing_.run(tiles) : natural_.run(tiles);
  }

  Result<Dem> finish() {
    if (digest_) {
      asked_.manifest.digest = digest_;
      file_->set_metadata(metadata_of(stamp_of(asked_.manifest)));
    }
    BOOST_OUTCOME_TRY(bytes, file_->finish([&](double done) {
      if (options_.progress) options_.progress(terrain::drawing_part + (1 - terrain::drawing_part) * done);
      return !stop_.stop_requested();
    }));
    return Dem{.path = target_,
               .width = asked_.grid.width,
               .height = asked_.grid.height,
               .pixels = file_->pixels(),
               .left_out = drawing_.left_out() + natural_.left_out(),
               .bytes = bytes,
               .note = terrain::note_of(asked_.manifest, options_.box, natural_.unknown())};
  }

 private:
  Impl(fs::path out, terrain::Asked asked, fs::path target, DemOptions options, std::stop_token stop,
       std::unique_ptr<terrain::CogFile> file)
      : out_(std::move(out)),
        asked_(std::move(asked)),
        target_(std::move(target)),
        options_(std::move(options)),
        stop_(std::move(stop)),
        file_(std::move(file)),
        drawing_(out_, asked_.manifest, asked_.column, asked_.grid,
                 terrain::drawing_options(options_, options_.memory_bytes / 4 * 3), stop_,
                 [this](terrain::Blocks& blocks) { return file_->add(blocks); }),
        natural_(asked_.column, asked_.grid, terrain::drawing_options(options_, options_.memory_bytes / 4 * 3),
                 options_.method, stop_, [this](terrain::Blocks& blocks) { return file_->add(blocks); }) {}

  fs::path out_;
  terrain::Asked asked_;
  fs::path target_;
  DemOptions options_;
  std::stop_token stop_;
  std::unique_ptr<terrain::CogFile> file_;
  terrain::Drawing drawing_;  // refers to the members above
  terrain::NaturalDrawing natural_;
  std::mutex mutex_;
  std::optional<Digest> digest_;  // of the tiles that were drawn new
};

DemMaker::DemMaker(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DemMaker::~DemMaker() = default;

Result<std::unique_ptr<DemMaker>> DemMaker::begin(const fs::path& name, const Manifest& manifest,
                                                  const fs::path& target, const DemOptions& options,
                                                  const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(impl, Impl::begin(name, manifest, target, options, stop));
  return std::unique_ptr<DemMaker>(new DemMaker(std::move(impl)));
}

Status DemMaker::use(const StoredTile& cells) { return impl_->draw_new(cells); }

Result<Dem> DemMaker::finish() { return impl_->finish(); }

Status check_dem_target(const fs::path& target, bool overwrite) {
  if (const std::string ending = exports::ending_of(target); ending != ".tif" && ending != ".tiff")
    return error(Errc::usage, target.string() + ": will be a GeoTIFF, so give a name that ends in .tif");
  return exports::check_free(target, overwrite);
}

Result<Dem> write_dem(const fs::path& out, const fs::path& target, const DemOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_dem_target(target, options.overwrite));
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  BOOST_OUTCOME_TRY(dem, DemMaker::Impl::begin(out, source.manifest(), target, options, stop));
  BOOST_OUTCOME_TRYV(dem->draw(source));
  return dem->finish();
}

Result<Dem> write_dem_of(const fs::path& out, const Manifest& manifest, const StoredTile& cells, const fs::path& target,
                         const DemOptions& options, std::stop_token stop) {
  if (options.method != DemMethod::linear) return write_dem(out, target, options, stop);
  BOOST_OUTCOME_TRY(dem, DemMaker::Impl::begin(out, manifest, target, options, stop));
  BOOST_OUTCOME_TRYV(dem->draw(cells));
  return dem->finish();
}

Result<DemArray> draw_dem(const fs::path& out, const DemOptions& options, std::uint64_t pixels_max,
                          std::stop_token stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  BOOST_OUTCOME_TRY(asked, terrain::read_request(out, source.manifest(), options));
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
  BOOST_OUTCOME_TRY(entries, terrain::tiles_with_pixels(asked, source, options, stop));
  TileQueue tiles(source, std::move(entries), stop, [](double) {});
  const terrain::DrawingOptions how = terrain::drawing_options(options, options.memory_bytes);
  terrain::Drawing linear(out, asked.manifest, asked.column, grid, how, stop, take);
  terrain::NaturalDrawing natural(asked.column, grid, how, options.method, stop, take);
  BOOST_OUTCOME_TRYV(options.method == DemMethod::linear ? linear.run(tiles) : natural.run(tiles));
  array.left_out = linear.left_out() + natural.left_out();
  if (options.light) {
    BOOST_OUTCOME_TRYV(terrain::shade(array, grid.res, *options.light, stop));
  }
  return array;
}

}  // namespace tessera
