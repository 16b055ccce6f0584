#include "src/result/density/density.h"

#include <fcntl.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
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

bool is_image(const fs::path& target) { return exports::ending_of(target) != ".npy"; }

std::function<void(double)> part_of(const GridOptions& options) {
  if (!options.progress) return {};
  return [&options](double done) { options.progress(cells_part * done); };
}

std::string band_name(const GridOptions& options) {
  std::string names;
  for (const auto& name : options.names) names += (names.empty() ? "" : ",") + name;
  switch (options.kind) {
    case GridKind::density:
      return options.mass.empty() ? "density" : "density of " + options.mass;
    case GridKind::field:
      return names;
    case GridKind::divergence:
      return "divergence of " + names;
    case GridKind::curl:
      break;
  }
  return "curl of " + names;
}

Result<std::uint64_t> write_image(const fs::path& target, const GridRequest& request, const GridOptions& options,
                                  Gridding& gridding, const std::stop_token& stop) {
  const VoxelGrid& voxels = request.grid;
  const terrain::Grid grid{.res = voxels.res,
                           .column0 = voxels.first[0],
                           .row0 = voxels.first[1],
                           .width = voxels.size[0],
                           .height = voxels.size[1]};
  BOOST_OUTCOME_TRY(file, terrain::CogFile::create(target, grid,
                                                   {.crs = crs_or_none(request.source.manifest().crs),
                                                    .name = band_name(options),
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

// {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }
std::string npy_head(const VoxelGrid& grid, std::size_t components) {
  std::string shape;
  for (int axis = grid.dimension - 1; axis >= 0; --axis)
    shape += std::to_string(grid.size[static_cast<std::size_t>(axis)]) + ", ";
  if (components > 1) shape += std::to_string(components) + ", ";
  shape.resize(shape.size() - 2);
  constexpr std::size_t bytes = 128, before = 10;
  std::string head("\x93NUMPY\x01\x00\x76\x00", before);
  head += "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }";
  head.resize(bytes - 1, ' ');
  return head + "\n";
}

Result<std::uint64_t> write_array(const fs::path& target, const GridRequest& request, const GridOptions& options,
                                  Gridding& gridding) {
  const std::string head = npy_head(request.grid, request.quantity.components());
  TemporaryFile temporary(temporary_name(target));
  BOOST_OUTCOME_TRY(file, open_handle(temporary.path(), O_RDWR | O_CREAT | O_TRUNC, target));
  BOOST_OUTCOME_TRYV(write_at(file.get(), std::as_bytes(std::span(head)), 0, target));
  BOOST_OUTCOME_TRYV(
      gridding.for_each_run(options.memory_bytes / 4, [&](std::uint64_t place, std::span<const double> values) {
        return write_at(file.get(), std::as_bytes(values), head.size() + place * sizeof(double), target);
      }));
  BOOST_OUTCOME_TRY(bytes, size_of(file, target));
  BOOST_OUTCOME_TRYV(publish(temporary.path(), target));
  temporary.keep();
  BOOST_OUTCOME_TRYV(sync_folder(target.has_parent_path() ? target.parent_path() : fs::path(".")));
  return bytes;
}

}  // namespace

std::string to_json(const GridFile& file) {
  using Json = nlohmann::ordered_json;
  const GridFacts& facts = file.facts;
  Json size = Json::array(), origin = Json::array();
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(facts.dimension); ++axis) {
    size.push_back(facts.size[axis]);
    origin.push_back(facts.origin[axis]);
  }
  const auto number = [](const std::optional<double>& value) {
    return value && std::isfinite(*value) ? Json(*value) : Json();
  };
  const Json object{{"event", "density"},
                    {"output", file.path.string()},
                    {"size", std::move(size)},
                    {"origin", std::move(origin)},
                    {"res", facts.res},
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
  if (ending != ".tif" && ending != ".tiff" && ending != ".npy")
    return error(Errc::usage, target.string() + ": '" + ending +
                                  "' is not a format of grids; the formats are .tif, for images, and .npy");
  return exports::check_free(target, overwrite);
}

Result<GridFile> write_grid(const fs::path& out, const fs::path& target, const GridOptions& options,
                            std::stop_token stop) {
  BOOST_OUTCOME_TRYV(check_grid_target(target, options.overwrite));
  BOOST_OUTCOME_TRY(request, check_request(out, options));
  if (request.grid.dimension == 3 && is_image(target))
    return error(Errc::usage,
                 target.string() + ": a GeoTIFF holds an image, but " + out.string() + " is a 3D result; write a .npy");
  BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make(temporary_name_of_process(target.string() + ".sums")));
  BOOST_OUTCOME_TRY(gridding, Gridding::begin(request, options, scratch.path(), stop));
  BOOST_OUTCOME_TRYV(gridding.run(part_of(options)));
  BOOST_OUTCOME_TRY(bytes, is_image(target) ? write_image(target, request, options, gridding, stop)
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
                                   std::to_string(values_max) + ": " + option("res") + " must be larger, or " +
                                   option("bbox") + " smaller");
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
