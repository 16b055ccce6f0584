#include "src/result/volume/difference.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/crs/gdal_library.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/result/store/stamp.h"
#include "src/result/store/tile_store.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/cell_raster.h"
#include "src/result/terrain/cog_file.h"
#include "src/result/terrain/grid.h"
#include "src/result/tile_source.h"
#include "src/result/volume/box_tree.h"
#include "src/result/volume/polygons.h"

namespace tessera {

namespace fs = std::filesystem;

namespace volume {
namespace {

// The parts of the progress for A, and for A and B together.
constexpr double part_of_a = 0.4, part_of_both = 0.8;

// The heights of a surface at the centres of pixels; NaN where there is none.
class Heights {
 public:
  Heights() = default;
  virtual ~Heights() = default;
  Heights(const Heights&) = delete;
  Heights& operator=(const Heights&) = delete;
  // Sets the pixels of a part of the grid, line by line from the top. Error io.
  virtual Status read(const terrain::Grid& part, std::vector<double>& pixels) = 0;
};

class LevelHeights final : public Heights {
 public:
  explicit LevelHeights(double level) : level_(level) {}
  Status read(const terrain::Grid& part, std::vector<double>& pixels) override {
    pixels.assign(static_cast<std::size_t>(part.width * part.height), level_);
    return success();
  }

 private:
  double level_;
};

class BaseHeights final : public Heights {
 public:
  explicit BaseHeights(MapPolygons polygons) : polygons_(std::move(polygons)) {
    std::vector<FlatBox> boxes;
    for (std::size_t p = 0; p < polygons_.polygons.size(); ++p) {
      for (const Facet& facet : polygons_.polygons[p].facets) {
        facets_.push_back({&facet, p});
        boxes.push_back(box_of(facet));
      }
    }
    tree_ = BoxTree(boxes);
  }

  Status read(const terrain::Grid& part, std::vector<double>& pixels) override {
    pixels.assign(static_cast<std::size_t>(part.width * part.height), std::numeric_limits<double>::quiet_NaN());
    std::vector<std::size_t> of(pixels.size(), polygons_.polygons.size());  // the polygon of each pixel
    const FlatBox box{part.centre(part.column0), part.centre(part.row0), part.centre(part.column0 + part.width - 1),
                      part.centre(part.row0 + part.height - 1)};
    tree_.for_each_near(box, [&](std::uint32_t i) {
      const auto& [facet, polygon] = facets_[i];
      terrain::Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) triangle[k] = {{(*facet)[k].x, (*facet)[k].y, 0}, PointId{k}, (*facet)[k].z};
      terrain::for_each_pixel(part, triangle, [&](std::int64_t column, std::int64_t row, double value) {
        const auto at = static_cast<std::size_t>(part.line(row) * part.width + column - part.column0);
        if (polygon >= of[at]) return;
        of[at] = polygon;
        pixels[at] = value;
      });
    });
    return success();
  }

 private:
  MapPolygons polygons_;
  std::vector<std::pair<const Facet*, std::size_t>> facets_;
  BoxTree tree_;
};

// A raster that write_dem() made.
class RasterHeights final : public Heights {
 public:
  static Result<std::unique_ptr<Heights>> open(const fs::path& path, const terrain::Grid& grid) {
    BOOST_OUTCOME_TRY(gdal, gdal_library());
    const GdalQuiet quiet(*gdal);
    const char* const drivers[] = {"GTiff", nullptr};
    const GDALDatasetH dataset =
        gdal->GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, nullptr, nullptr);
    if (dataset == nullptr) return error(Errc::io, path.string() + ": cannot be read: " + quiet.message());
    return std::unique_ptr<Heights>(new RasterHeights(*gdal, dataset, path, grid));
  }
  ~RasterHeights() override {
    const GdalQuiet quiet(gdal_);
    gdal_.GDALClose(dataset_);
  }
  RasterHeights(const RasterHeights&) = delete;
  RasterHeights& operator=(const RasterHeights&) = delete;

  Status read(const terrain::Grid& part, std::vector<double>& pixels) override {
    const GdalQuiet quiet(gdal_);
    pixels.resize(static_cast<std::size_t>(part.width * part.height));
    const auto x = static_cast<int>(part.column0 - grid_.column0);
    const auto y = static_cast<int>(grid_.line(part.row0 + part.height - 1));
    const auto width = static_cast<int>(part.width), height = static_cast<int>(part.height);
    if (gdal_.GDALRasterIO(gdal_.GDALGetRasterBand(dataset_, 1), GF_Read, x, y, width, height, pixels.data(), width,
                           height, GDT_Float64, 0, 0) == CE_None)
      return success();
    return error(Errc::io, path_.string() + ": cannot be read: " + quiet.message());
  }

 private:
  RasterHeights(const GdalLibrary& gdal, GDALDatasetH dataset, fs::path path, const terrain::Grid& grid)
      : gdal_(gdal), dataset_(dataset), path_(std::move(path)), grid_(grid) {}

  const GdalLibrary& gdal_;
  GDALDatasetH dataset_;
  fs::path path_;
  terrain::Grid grid_;
};

std::optional<Bounds> common(const Bounds& a, const Bounds& b) {
  const Bounds both{{std::max(a.lo.x, b.lo.x), std::max(a.lo.y, b.lo.y), 0},
                    {std::min(a.hi.x, b.hi.x), std::min(a.hi.y, b.hi.y), 0}};
  if (both.lo.x < both.hi.x && both.lo.y < both.hi.y) return both;
  return std::nullopt;
}

class DifferenceDrawing {
 public:
  DifferenceDrawing(const VolumeOptions& options, double res, std::stop_token stop)
      : options_(options), res_(res), stop_(std::move(stop)) {}

  // Draws the heights of a result at the pixels of the box.
  Result<std::unique_ptr<Heights>> draw(const fs::path& out, const fs::path& to, const Bounds& box,
                                        const terrain::Grid& grid, double from, double until) const {
    DemOptions drawing{.res = res_,
                       .box = box,
                       .max_edge = options_.max_edge,
                       .max_radius = options_.max_radius,
                       .value = options_.value};
    drawing.doubles = true;
    drawing.memory_bytes = options_.memory_bytes;
    drawing.threads = options_.threads;
    drawing.progress = [&, from, until](double done) { tell(from + (until - from) * done); };
    BOOST_OUTCOME_TRYV(write_dem(out, to, drawing, stop_));
    return RasterHeights::open(to, grid);
  }

  // Subtracts block by block.
  Status subtract(Heights& a, Heights& b, const terrain::Grid& grid, terrain::CogFile& file) const {
    std::vector<double> upper, lower;
    terrain::Grid part = grid;
    // Blocks of the raster are counted from its top.
    for (std::int64_t top = 0; top < grid.height; top += terrain::block_side) {
      part.height = std::min(terrain::block_side, grid.height - top);
      part.row0 = grid.row0 + grid.height - top - part.height;
      for (std::int64_t left = 0; left < grid.width; left += terrain::block_side) {
        if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while drawing");
        part.column0 = grid.column0 + left;
        part.width = std::min(terrain::block_side, grid.width - left);
        BOOST_OUTCOME_TRYV(a.read(part, upper));
        BOOST_OUTCOME_TRYV(b.read(part, lower));
        terrain::Blocks blocks(grid);
        for (std::int64_t row = part.row0; row < part.row0 + part.height; ++row) {
          for (std::int64_t column = part.column0; column < part.column0 + part.width; ++column) {
            const auto at = static_cast<std::size_t>(part.line(row) * part.width + column - part.column0);
            blocks.put(column, row, static_cast<double>(static_cast<float>(upper[at] - lower[at])));
          }
        }
        BOOST_OUTCOME_TRYV(file.add(blocks));
      }
      tell(part_of_both + 0.1 * static_cast<double>(top) / static_cast<double>(grid.height));
    }
    return success();
  }

  void tell(double done) const {
    if (options_.progress) options_.progress(done);
  }

 private:
  const VolumeOptions& options_;
  double res_;
  std::stop_token stop_;
};

}  // namespace
}  // namespace volume

Result<Dem> write_difference(const fs::path& a, const std::optional<fs::path>& b, const fs::path& target, double res,
                             bool overwrite, const VolumeOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_volume_options(b.has_value(), options));
  BOOST_OUTCOME_TRYV(check_dem_target(target, overwrite));
  BOOST_OUTCOME_TRY(source, TileSource::open(a));
  const Manifest& manifest = source.manifest();
  std::optional<Bounds> box = manifest.bounds;
  std::unique_ptr<volume::Heights> lower;
  std::optional<ResultStamp> of_lower;
  if (options.plane) lower = std::make_unique<volume::LevelHeights>(*options.plane);
  if (!options.base.empty()) {
    BOOST_OUTCOME_TRY(
        polygons, volume::read_polygons(
                      options.base, {.name = options.name, .heights = true, .bytes_max = options.memory_bytes / 4}));
    BOOST_OUTCOME_TRYV(polygons.frame.check_in(manifest.crs, manifest.bounds));
    box = volume::common(*box, polygons.frame.bounds);
    lower = std::make_unique<volume::BaseHeights>(std::move(polygons));
  }
  if (b) {
    BOOST_OUTCOME_TRY(other, TileSource::open(*b));
    BOOST_OUTCOME_TRYV(check_same_system(a, manifest.crs, *b, other.manifest().crs));
    box = volume::common(*box, other.manifest().bounds);
    of_lower = stamp_of(other.manifest());
  }
  if (!box)
    return error(Errc::usage,
                 a.string() + ": has no area in common with what it is compared with, so there is no raster");
  BOOST_OUTCOME_TRY(grid, terrain::grid_over(res, *box, manifest.bounds));
  BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make(temporary_name_of_process(target.string() + ".parts")));
  const volume::DifferenceDrawing drawing(options, res, stop);
  BOOST_OUTCOME_TRY(
      upper, drawing.draw(a, scratch.path() / "a.tif", *box, grid, 0, b ? volume::part_of_a : volume::part_of_both));
  if (b) {
    BOOST_OUTCOME_TRY(drawn,
                      drawing.draw(*b, scratch.path() / "b.tif", *box, grid, volume::part_of_a, volume::part_of_both));
    lower = std::move(drawn);
  }
  BOOST_OUTCOME_TRY(file, terrain::CogFile::create(target, grid,
                                                   {.crs = crs_or_none(manifest.crs),
                                                    .name = "difference",
                                                    .heights = false,
                                                    .cache_bytes = options.memory_bytes / 4,
                                                    .threads = options.threads,
                                                    .metadata = metadata_of(stamp_of(manifest), of_lower)}));
  BOOST_OUTCOME_TRYV(drawing.subtract(*upper, *lower, grid, *file));
  BOOST_OUTCOME_TRY(bytes, file->finish([&](double done) {
    drawing.tell(0.9 + 0.1 * done);
    return !stop.stop_requested();
  }));
  return Dem{.path = target,
             .width = grid.width,
             .height = grid.height,
             .pixels = file->pixels(),
             .left_out = 0,
             .bytes = bytes,
             .note = {}};
}

}  // namespace tessera
