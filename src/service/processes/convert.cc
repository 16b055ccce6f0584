#include "src/service/processes/convert.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/column_names.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"
#include "src/result/heights/copies.h"
#include "src/service/json.h"
#include "src/service/processes/refuse.h"
#include "src/tiling/partition.h"

namespace tessera::service {
namespace {

// "crop: is an empty box", with a mark for the option.
Status read_tiles(const proto::TriangulateInputs& inputs, const JobShare& share, JobOptions& options) {
  if (inputs.has_tiles() && inputs.has_tile_points()) {
    return error(Errc::usage, option("tiles") + " and " + option("max-points-per-tile") +
                                  " contradict each other: give one of them");
  }
  if (inputs.has_tiles()) {
    if (inputs.tiles() < 1 || inputs.tiles() > Partition::tiles_max)
      return refuse("tiles", "is not a number from 1 to " + std::to_string(Partition::tiles_max));
    options.tiles = inputs.tiles();
  }
  if (inputs.has_tile_points()) {
    if (inputs.tile_points() < 1) return refuse("max-points-per-tile", "must be at least 1");
    options.max_points_per_tile = inputs.tile_points();
  }
  if (inputs.has_partition()) {
    const auto kind = parse_partition_kind(inputs.partition());
    if (!kind) return refuse("partition", kind.error().where);
    options.partition = kind.value();
  }
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  options.threads = own.threads;
  options.memory_bytes = own.memory_bytes;
  if (inputs.has_kernel()) {
    if (inputs.kernel() != "flat" && inputs.kernel() != "cgal")
      return refuse("kernel", "'" + inputs.kernel() + "' is not a kernel; the kernels are flat and cgal");
    options.kernel = inputs.kernel() == "flat" ? KernelKind::flat : KernelKind::cgal;
  }
  if (inputs.has_store()) {
    const auto store = parse_store_as(inputs.store());
    if (!store) return refuse("store", store.error().where);
    options.store = store.value();
  }
  if (inputs.has_neighbors()) options.neighbors = inputs.neighbors();
  return success();
}

Status read_cloud(const proto::TriangulateInputs& inputs, CloudOptions& cloud) {
  cloud.dimension = 0;
  if (inputs.has_dim()) {
    if (inputs.dim() != 2 && inputs.dim() != 3) return refuse("dim", "is neither 2 nor 3");
    cloud.dimension = inputs.dim();
  }
  if (inputs.crop_size() > 0) {
    const std::vector<double> numbers(inputs.crop().begin(), inputs.crop().end());
    const bool finite = std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (!finite) return refuse("crop", "is not a box: one of its numbers is not finite");
    const auto box = crop_box(numbers, cloud.dimension == 2 ? 2 : 3);
    if (!box) return refuse("crop", box.error().where);
    cloud.crop = box.value();
  }
  if (inputs.has_resolution()) {
    BOOST_OUTCOME_TRY(resolution, length_of("resolution", inputs.resolution()));
    cloud.resolution = resolution;
  }
  constexpr int classes_max = 256;  // no class is higher
  if (inputs.class__size() > classes_max)
    return refuse("class", "has " + std::to_string(inputs.class__size()) + " numbers, and there are 256 classes");
  for (const auto number : inputs.class_()) {
    if (number > 255)
      return refuse("class", std::to_string(number) + " is not a LAS class, which is a number from 0 to 255");
    cloud.classes.push_back(static_cast<int>(number));
  }
  constexpr int scans_max = 10'000;
  if (inputs.scan_size() > scans_max)
    return refuse("scan", "has " + std::to_string(inputs.scan_size()) + " numbers; at most " +
                              std::to_string(scans_max) + " can be given");
  cloud.scans.assign(inputs.scan().begin(), inputs.scan().end());
  if (inputs.has_returns()) {
    const auto returns = parse_returns(inputs.returns());
    if (!returns) return refuse("returns", returns.error().where);
    cloud.returns = returns.value();
  }
  cloud.without = list_of(inputs.without());
  if (const auto flags = check_flags(cloud.without); !flags) return refuse("without", flags.error().where);
  cloud.columns = list_of(inputs.columns());
  if (const auto columns = check_columns(cloud.columns); !columns) return refuse("columns", columns.error().where);
  cloud.attributes = list_of(inputs.attributes());
  if (std::find(cloud.attributes.begin(), cloud.attributes.end(), "") != cloud.attributes.end())
    return refuse("attributes", "one of the names is empty");
  if (inputs.has_crs()) {
    // Never the name of a file, nor a text with a file name in it: the service opens only inputs, and PROJ only its own
    // files.
    if (const auto known = check_crs(inputs.crs()); !known)
      return refuse("crs", in_quotes(inputs.crs()) + ": " + known.error().where);
    cloud.crs = inputs.crs();
  }
  if (inputs.has_keep()) {
    const auto keep = parse_kept_point(inputs.keep());
    if (!keep) return refuse("keep", keep.error().where);
    cloud.keep = keep.value();
  }
  if (inputs.periodic_size() > 3) return refuse("periodic", "has more than three numbers");
  cloud.periodic.assign(inputs.periodic().begin(), inputs.periodic().end());
  if (inputs.has_periodic_snap()) cloud.snap = inputs.periodic_snap();
  if (inputs.has_heights()) cloud.heights = inputs.heights();
  if (inputs.has_skip_invalid()) cloud.skip_invalid = inputs.skip_invalid();
  if (inputs.has_recursive()) cloud.recursive = inputs.recursive();
  return success();
}

// Copies fields with equal names, which have equal types, by name.
Result<proto::TriangulateInputs> renamed(const google::protobuf::Message& shared) {
  auto json = parse_json(to_json(shared));
  json.erase("bbox");  // a list, which is written even when empty
  proto::TriangulateInputs cloud;
  BOOST_OUTCOME_TRYV(from_json(json_text(json), cloud));
  return cloud;
}

}  // namespace

Result<double> length_of(const char* key, double value) {
  if (!std::isfinite(value) || value <= 0) return refuse(key, "must be a finite number above 0");
  return value;
}

Result<std::uint32_t> threads_of(std::uint32_t asked, const JobShare& share) {
  if (asked < 1 || asked > threads_max)
    return refuse("threads", "is not a number from 1 to " + std::to_string(threads_max));
  return std::min(share.threads, asked);
}

Result<std::uint64_t> memory_of(const std::string& text, const JobShare& share) {
  const auto asked = parse_memory(text);
  if (!asked) return refuse("memory", asked.error().where);
  if (asked.value() == 0) return refuse("memory", "must be more than 0");
  return std::min(asked.value(), share.memory_bytes);
}

std::string beyond_share(const proto::Inputs& inputs, const JobShare& share) {
  std::string told;
  const auto tell = [&](const char* key, const std::string& asked, const std::string& has) {
    told += (told.empty() ? "" : "; ") + option(key) + ": " + asked + " are asked for, but a job gets " + has + " here";
  };
  const auto look = [&](const auto& of) {
    if constexpr (requires { of.threads(); }) {
      if (of.threads() > share.threads) tell("threads", std::to_string(of.threads()), std::to_string(share.threads));
    }
    if (!of.has_memory()) return;
    const auto asked = parse_memory(of.memory());
    if (asked && asked.value() > share.memory_bytes)
      tell("memory", human_bytes(asked.value()), human_bytes(share.memory_bytes));
  };
  if (inputs.has_triangulate()) look(inputs.triangulate());
  if (inputs.has_verify()) look(inputs.verify());
  if (inputs.has_info()) look(inputs.info());
  if (inputs.has_region()) look(inputs.region());
  if (inputs.has_dem()) look(inputs.dem());
  if (inputs.has_contours()) look(inputs.contours());
  if (inputs.has_surface()) look(inputs.surface());
  if (inputs.has_hag()) look(inputs.hag());
  if (inputs.has_measure()) look(inputs.measure());
  if (inputs.has_voronoi()) look(inputs.voronoi());
  if (inputs.has_density()) look(inputs.density());
  if (inputs.has_alpha()) look(inputs.alpha());
  if (inputs.has_volume()) look(inputs.volume());
  if (inputs.has_update()) look(inputs.update());
  return told;
}

std::vector<std::string> list_of(const google::protobuf::RepeatedPtrField<std::string>& texts) {
  return {texts.begin(), texts.end()};
}

Result<JobOptions> job_options(const proto::TriangulateInputs& inputs, const JobShare& share) {
  JobOptions options;
  BOOST_OUTCOME_TRYV(read_tiles(inputs, share, options));
  BOOST_OUTCOME_TRYV(read_cloud(inputs, options.cloud));
  options.cloud.threads = options.threads;
  return options;
}

Result<proto::TriangulateInputs> cloud_of(const proto::InfoInputs& inputs) {
  proto::InfoInputs shared = inputs;
  shared.clear_triangulation();
  shared.clear_stats();
  return renamed(shared);
}

Result<proto::TriangulateInputs> cloud_of(const proto::RegionInputs& inputs) {
  proto::RegionInputs shared = inputs;
  shared.clear_output();
  shared.clear_overwrite();
  shared.clear_bbox();
  shared.clear_polygon();
  shared.clear_max_points();
  shared.clear_max_seconds();
  shared.clear_partial();
  shared.clear_scan_files();
  return renamed(shared);
}

Result<VerifyOptions> verify_options(const proto::VerifyInputs& inputs, const JobShare& share) {
  VerifyOptions options;
  options.memory_bytes = share.memory_bytes;
  if (inputs.has_memory()) {
    BOOST_OUTCOME_TRY(bytes, memory_of(inputs.memory(), share));
    options.memory_bytes = bytes;
  }
  options.against_cgal = inputs.against_cgal();
  return options;
}

Result<ExportOptions> export_options(const proto::ExportInputs& inputs) {
  ExportOptions options;
  options.format = inputs.format();
  if (inputs.has_heights()) options.heights = inputs.heights();
  if (inputs.has_spatial_index()) options.spatial_index = inputs.spatial_index();
  if (inputs.has_max_edge()) {
    BOOST_OUTCOME_TRY(edge, length_of("max-edge", inputs.max_edge()));
    options.max_edge = edge;
  }
  if (inputs.has_max_radius()) {
    BOOST_OUTCOME_TRY(radius, length_of("max-radius", inputs.max_radius()));
    options.max_radius = radius;
  }
  options.local = inputs.local();
  options.names = list_of(inputs.names());
  options.overwrite = inputs.overwrite();
  return options;
}

Result<HeightsOptions> heights_options(const proto::HagInputs& inputs, const JobShare& share) {
  HeightsOptions options;
  if (inputs.has_format()) {
    const auto packing = parse_las_packing(inputs.format());
    if (!packing) return refuse("format", packing.error().where);
    options.packing = packing.value();
  }
  if (inputs.has_outside()) {
    if (!std::isfinite(inputs.outside())) return refuse("outside", "must be finite");
    options.outside = inputs.outside();
  }
  options.replace = inputs.replace();
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  options.threads = own.threads;
  return options;
}

Result<MeasureOptions> measure_options(const proto::MeasureInputs& inputs, const JobShare& share) {
  MeasureOptions options{.volume = inputs.volume(),
                         .quality = inputs.quality(),
                         .voronoi = inputs.voronoi(),
                         .density = inputs.density(),
                         .mass = inputs.mass()};
  BOOST_OUTCOME_TRYV(check_measure_options(options));
  BOOST_OUTCOME_TRY(own, share_of_job(inputs, share));
  options.memory_bytes = own.memory_bytes;
  options.threads = own.threads;
  return options;
}

}  // namespace tessera::service
