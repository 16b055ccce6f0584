#include "src/result/density/density.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/density/array_files.h"
#include "src/result/density/gridding.h"
#include "src/result/export/ending.h"
#include "src/result/store/stamp.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/cog_file.h"
#include "src/result/terrain/grid.h"

namespace tessera::density {

namespace fs = std::filesystem;

namespace {

// The fraction of the progress for cells; the rest is for writing.
constexpr double cells_part = 0.9;

std::function<void(double)> part_of(const GridOptions& options) {
  if (!options.progress) return {};
  return [&options](double done) { options.progress(cells_part * done); };
}

// A GeoTIFF has square pixels, and an edge between pixels at 0.
Result<terrain::Grid> image_grid(const fs::path& target, const VoxelGrid& voxels) {
  const auto res = voxels.res();
  if (!res || voxels.axes[0].origin != 0 || voxels.axes[1].origin != 0)
    return error(Errc::usage, target.string() +
                                  ": the pixels of a GeoTIFF are squares, on a grid that all images of the same width "
                                  "have; these are not. Write a .npy, .h5 or .fits, or give " +
                                  option("res"));
  return terrain::Grid{.res = *res,
                       .column0 = voxels.first[0],
                       .row0 = voxels.first[1],
                       .width = voxels.size[0],
                       .height = voxels.size[1]};
}

Result<std::uint64_t> write_image(const fs::path& target, const GridRequest& request, const GridOptions& options,
                                  Gridding& gridding, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(grid, image_grid(target, request.grid));
  BOOST_OUTCOME_TRY(file, terrain::CogFile::create(target, grid,
                                                   {.crs = crs_or_none(request.source.manifest().crs),
                                                    .name = labels_of(request, options).about,
                                                    .doubles = true,
                                                    .heights = false,
                                                    .cache_bytes = options.memory_bytes / 4,
                                                    .threads = options.threads,
                                                    .metadata = metadata_of(stamp_of(request.source.manifest()))}));
  terrain::Blocks blocks(grid);
  BOOST_OUTCOME_TRYV(gridding.for_each_run(
      options.memory_bytes / 4, [&](std::uint64_t place, std::span<const double> values) -> Status {
        const auto first = static_cast<std::int64_t>(place);
        for (std::size_t i = 0; i < values.size(); ++i)
          blocks.put(grid.column0 + first % grid.width + static_cast<std::int64_t>(i), grid.row0 + first / grid.width,
                     values[i]);
        if (blocks.bytes() <= options.memory_bytes / 4) return success();
        return file->add(blocks);
      }));
  BOOST_OUTCOME_TRYV(file->add(blocks));
  return file->finish([&](double done) {
    if (options.progress) options.progress(cells_part + (1 - cells_part) * done);
    return !stop.stop_requested();
  });
}

// Error usage when a GeoTIFF cannot hold the grid.
Status check_image(const fs::path& out, const fs::path& target, const GridRequest& request) {
  if (request.grid.dimension == 3)
    return error(Errc::usage, target.string() + ": a GeoTIFF holds an image, but " + out.string() +
                                  " is a 3D result; write a .npy, .h5 or .fits");
  if (request.quantity.components() > 1)
    return error(Errc::usage, target.string() + ": a GeoTIFF has room for one number a pixel, but the shear has " +
                                  std::to_string(request.quantity.components()) + "; write a .npy, .h5 or .fits");
  BOOST_OUTCOME_TRYV(image_grid(target, request.grid));
  return success();
}

using WriteGrid = Result<std::uint64_t> (*)(const fs::path&, const GridRequest&, const GridOptions&, Gridding&);

// What writes an array file with this ending; null for an image.
WriteGrid array_writer(const fs::path& target) {
  const std::string ending = exports::ending_of(target);
  if (ending == ".npy") return write_npy;
  if (ending == ".h5" || ending == ".hdf5") return write_hdf5;
  return ending == ".fits" ? write_fits : nullptr;
}

}  // namespace

std::string to_json(const GridFile& file) {
  using Json = nlohmann::ordered_json;
  const GridFacts& facts = file.facts;
  Json size = Json::array(), origin = Json::array(), widths = Json::array(), period = Json::array();
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(facts.dimension); ++axis) {
    size.push_back(facts.size[axis]);
    origin.push_back(facts.origin[axis]);
    widths.push_back(facts.widths[axis]);
    period.push_back(facts.period[axis]);
  }
  const auto number = [](const std::optional<double>& value) {
    return value && std::isfinite(*value) ? Json(*value) : Json();
  };
  const Json object{{"event", "density"},
                    {"output", file.path.string()},
                    {"size", std::move(size)},
                    {"origin", std::move(origin)},
                    {"res", number(facts.res)},
                    {"widths", std::move(widths)},
                    {"period", std::move(period)},
                    {"components", facts.components},
                    {"known", facts.known},
                    {"mass", number(facts.mass)},
                    {"grid_mass", number(facts.grid_mass)},
                    {"bytes", file.bytes},
                    {"note", facts.note}};
  return json_text(object);
}

Status check_grid_target(const fs::path& target, bool overwrite) {
  const std::string ending = exports::ending_of(target);
  if (ending != ".tif" && ending != ".tiff" && array_writer(target) == nullptr)
    return error(Errc::usage, target.string() + ": '" + ending +
                                  "' is not a format of grids; the formats are .npy, .h5, .fits, and for images .tif");
  return exports::check_free(target, overwrite);
}

Result<VoxelGrid> grid_of(const fs::path& out, const GridOptions& options) {
  BOOST_OUTCOME_TRY(request, check_request(out, options));
  return request.grid;
}

Result<GridFile> write_grid(const fs::path& out, const fs::path& target, const GridOptions& options,
                            std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_grid_target(target, options.overwrite));
  BOOST_OUTCOME_TRY(request, check_request(out, options));
  const WriteGrid write_array = array_writer(target);
  if (write_array == nullptr) {
    BOOST_OUTCOME_TRYV(check_image(out, target, request));
  }
  BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make(temporary_name_of_process(target.string() + ".sums")));
  BOOST_OUTCOME_TRY(gridding, Gridding::begin(request, options, scratch.path(), stop));
  BOOST_OUTCOME_TRYV(gridding.run(part_of(options)));
  BOOST_OUTCOME_TRY(bytes, write_array == nullptr ? write_image(target, request, options, gridding, stop)
                                                  : write_array(target, request, options, gridding));
  return GridFile{target, gridding.facts(), bytes};
}

Result<GridArray> draw_grid(const fs::path& out, const fs::path& scratch, const GridOptions& options,
                            std::uint64_t values_max, std::stop_token stop) {
  BOOST_OUTCOME_TRY(request, check_request(out, options));
  const auto voxels = static_cast<std::uint64_t>(request.grid.voxels());
  const std::uint64_t values = voxels * request.quantity.components();
  if (values > values_max)
    return error(Errc::memory, out.string() + ": the grid has " + std::to_string(values) + " values, more than " +
                                   std::to_string(values_max) + ": " +
                                   (options.shape.voxels.empty()
                                        ? option("res") + " must be larger, or " + option("bbox") + " smaller"
                                        : option("grid") + " must be smaller"));
  BOOST_OUTCOME_TRY(gridding, Gridding::begin(request, options, scratch, std::move(stop)));
  BOOST_OUTCOME_TRYV(gridding.run(part_of(options)));
  GridArray array;
  array.values.resize(values);
  BOOST_OUTCOME_TRYV(
      gridding.for_each_run(options.memory_bytes / 4, [&](std::uint64_t place, std::span<const double> run) -> Status {
        std::copy(run.begin(), run.end(), array.values.begin() + static_cast<std::ptrdiff_t>(place));
        return success();
      }));
  array.facts = gridding.facts();
  return array;
}

}  // namespace tessera::density
