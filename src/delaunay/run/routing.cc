#include "src/delaunay/run/routing.h"

#include <span>
#include <string>
#include <utility>

#include "job.pb.h"
#include "src/base/files/frame.h"
#include "src/base/files/names.h"
#include "src/base/periodic_box.h"
#include "src/input/column_names.h"
#include "src/input/cosmology.h"

namespace tessera {
namespace {

using Of = InputSplit::Range::Of;

// Returns the path as every node understands it.
std::string absolute_path(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::absolute(path, ignored).string();
}

Result<proto::Routing> read_routing(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(bytes, read_frame(path, ScratchKind::routing, {}));
  proto::Routing routing;
  if (!routing.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return damaged_run(path, "is not a valid description of how the points are routed");
  return routing;
}

Result<Cloud> cloud_of(const proto::Routing& routing, const std::filesystem::path& path, std::uint32_t threads) {
  const auto refuse = [&](const char* what) { return damaged_run(path, what); };
  std::vector<FileInfo> files;
  for (const auto& from : routing.files()) {
    FileInfo file;
    file.path = from.path();
    file.bytes = from.bytes();
    file.modified_ns = from.modified_ns();
    file.parts = from.parts();
    if (from.has_points()) file.points = from.points();
    files.push_back(std::move(file));
  }
  std::vector<Attribute> schema;
  for (const auto& from : routing.schema()) {
    if (from.type() > static_cast<std::uint32_t>(AttributeType::f64)) return refuse("has an attribute of unknown type");
    schema.push_back({from.name(), static_cast<AttributeType>(from.type())});
  }
  CloudOptions options;
  options.dimension = routing.dimension();
  options.skip_invalid = routing.skip_invalid();
  if (routing.returns() > static_cast<std::uint32_t>(Returns::single))
    return refuse("has an unknown choice of returns");
  options.returns = static_cast<Returns>(routing.returns());
  if (routing.crop_size() == 6) {
    const auto& c = routing.crop();
    options.crop = Box{{c[0], c[1], c[2]}, {c[3], c[4], c[5]}};
  }
  options.classes.assign(routing.classes().begin(), routing.classes().end());
  options.scans.assign(routing.scans().begin(), routing.scans().end());
  options.without.assign(routing.without().begin(), routing.without().end());
  options.columns.assign(routing.columns().begin(), routing.columns().end());
  if (!check_columns(options.columns)) return refuse("has names of columns that cannot be read as points");
  options.particles.assign(routing.particles().begin(), routing.particles().end());
  options.hdu = routing.hdu();
  if (routing.cosmology_size() > 0) {
    options.cosmology =
        Cosmology{.hubble = routing.cosmology(0), .matter = routing.cosmology().at(routing.cosmology_size() - 1)};
    if (routing.cosmology_size() != 2 || !why_no_cosmology(*options.cosmology).empty())
      return refuse("has an impossible cosmology");
  }
  options.resolution = routing.resolution();
  if (routing.period_size() > 0) {
    if (routing.period_size() != 3) return refuse("has an impossible period");
    for (int axis = 0; axis < 3; ++axis) {
      const double length = routing.period(axis);
      if (length != 0 && !is_period(length)) return refuse("has an impossible period");
      options.period.length[static_cast<std::size_t>(axis)] = length;
    }
  }
  options.snap = !routing.exact();
  options.threads = threads;
  return Cloud::of(std::move(files), std::move(schema), std::move(options));
}

Result<InputSplit> split_of(const proto::Routing& routing, const std::filesystem::path& path, std::size_t number) {
  if (number >= static_cast<std::size_t>(routing.splits_size()))
    return damaged_run(path, "does not have the piece of the input that is asked for");
  InputSplit split;
  for (const auto& from : routing.splits(static_cast<int>(number)).ranges()) {
    if (from.file() >= static_cast<std::uint64_t>(routing.files_size()) ||
        !proto::Routing::Range::Of_IsValid(from.of()))
      return damaged_run(path, "has a piece of the input that belongs to no file");
    split.ranges.push_back({from.file(), static_cast<Of>(from.of()), from.begin(), from.count()});
  }
  return split;
}

}  // namespace

Status write_routing(const std::filesystem::path& run_folder, const Cloud& cloud, const std::vector<InputSplit>& splits,
                     const Partition& partition) {
  proto::Routing routing;
  routing.set_partition(partition.to_json());
  for (const Attribute& a : cloud.schema()) {
    auto& to = *routing.add_schema();
    to.set_name(a.name);
    to.set_type(static_cast<std::uint32_t>(a.type));
  }
  for (const FileInfo& file : cloud.files()) {
    auto& to = *routing.add_files();
    to.set_path(absolute_path(file.path));
    to.set_bytes(file.bytes);
    to.set_modified_ns(file.modified_ns);
    to.set_parts(file.parts);
    if (file.points) to.set_points(*file.points);
  }
  for (const InputSplit& split : splits) {
    auto& to = *routing.add_splits();
    for (const InputSplit::Range& range : split.ranges) {
      auto& r = *to.add_ranges();
      r.set_file(range.file);
      r.set_of(static_cast<proto::Routing::Range::Of>(range.of));
      r.set_begin(range.begin);
      r.set_count(range.count);
    }
  }
  const CloudOptions& options = cloud.options();
  routing.set_dimension(options.dimension);
  routing.set_skip_invalid(options.skip_invalid);
  routing.set_returns(static_cast<std::uint32_t>(options.returns));
  if (options.crop) {
    for (const Point& p : {options.crop->lo, options.crop->hi})
      for (int i = 0; i < 3; ++i) routing.add_crop(p[i]);
  }
  routing.mutable_classes()->Assign(options.classes.begin(), options.classes.end());
  routing.mutable_scans()->Assign(options.scans.begin(), options.scans.end());
  for (const std::string& flag : options.without) routing.add_without(flag);
  for (const std::string& name : options.columns) routing.add_columns(name);
  routing.mutable_particles()->Assign(options.particles.begin(), options.particles.end());
  routing.set_hdu(options.hdu);
  if (options.cosmology) {
    routing.add_cosmology(options.cosmology->hubble);
    routing.add_cosmology(options.cosmology->matter);
  }
  routing.set_resolution(options.resolution);
  if (options.period.any())
    routing.mutable_period()->Assign(options.period.length.begin(), options.period.length.end());
  routing.set_exact(!options.snap);
  const std::string bytes = routing.SerializeAsString();
  return write_frame(routing_file(run_folder), ScratchKind::routing, {}, std::as_bytes(std::span(bytes)));
}

Status route_split(const std::filesystem::path& run_folder, std::size_t split, std::uint32_t threads,
                   const SplitWork& work, const std::stop_token& stop) {
  const auto path = routing_file(run_folder);
  BOOST_OUTCOME_TRY(routing, read_routing(path));
  BOOST_OUTCOME_TRY(cloud, cloud_of(routing, path, threads));
  BOOST_OUTCOME_TRY(wanted, split_of(routing, path, split));
  auto partition = Partition::from_json(routing.partition());
  if (!partition) return damaged_run(path, partition.error().where);
  return route_split(cloud, wanted, partition.value(), work, stop);
}

}  // namespace tessera
