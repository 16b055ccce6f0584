#include <fcntl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "src/base/attribute.h"
#include "src/base/crs/crs.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/there.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/base/phases.h"
#include "src/input/bytes/objects.h"
#include "src/input/bytes/spool.h"
#include "src/input/cloud/cloud_sample.h"
#include "src/input/cloud/inputs.h"
#include "src/input/snapshot/particle_types.h"
#include "src/job/describe.h"
#include "src/job/describe_points.h"
#include "src/job/describe_units.h"
#include "src/job/description.h"
#include "src/job/estimate.h"
#include "src/job/open_cloud.h"
#include "src/result/store/stamp.h"
#include "src/tiling/partition.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Bounds& bounds) {
  if (bounds.empty()) return nullptr;
  return {{"min", {bounds.lo.x, bounds.lo.y, bounds.lo.z}}, {"max", {bounds.hi.x, bounds.hi.y, bounds.hi.z}}};
}

Json to_json(const CoordinateColumns& columns) {
  using By = CoordinateColumns::By;
  Json json = Json::object();
  for (std::size_t axis = 0; axis < columns.numbers.size(); ++axis)
    json[std::string(1, "xyz"[axis])] = columns.numbers[axis];
  json["by"] = columns.by == By::place ? "place" : columns.by == By::header ? "header" : "option";
  return json;
}

// Which result a mesh was exported from, as the comments at its beginning tell.
Result<Json> result_of(const FileInfo& file) {
  const bool has_comments = file.format == "ply" || file.format == "off" || file.format == "obj";
  if (!has_comments || !file.packing.empty()) return Json();
  BOOST_OUTCOME_TRY(regular, is_regular(file.path));
  if (!regular) return Json();  // standard input and pipes are read once only
  BOOST_OUTCOME_TRY(opened, open_handle(file.path, O_RDONLY));
  std::array<char, 1024> head{};
  BOOST_OUTCOME_TRY(read, read_up_to(opened.get(), std::as_writable_bytes(std::span(head)), 0, file.path));
  const auto stamp = stamp_in_comments({head.data(), read});
  return stamp ? parse_ordered_json(json_of(*stamp)) : Json();
}

Json to_json(const FileInfo& file) {
  Json names = Json::array();
  for (const auto& attribute : file.attributes) names.push_back(attribute.name);
  Json described{{"path", file.path.string()},
                 {"format", file.format},
                 {"detail", file.detail},
                 {"packing", file.packing},
                 {"dimension", file.dimension},
                 {"bytes", file.bytes},
                 {"points", file.points ? Json(*file.points) : Json()},
                 {"bounds", file.bounds ? to_json(*file.bounds) : Json()},
                 {"crs", file.crs},
                 {"crs_name", crs_title(file.crs)},
                 {"crs_note", file.crs_note},
                 {"attributes", names},
                 {"columns", file.columns ? to_json(*file.columns) : Json()}};
  if (Json units = units_of(file.unit, file.attributes); !units.empty()) described["units"] = std::move(units);
  if (!file.particles.empty()) {
    Json& kinds = described["particles"] = Json::array();
    for (const ParticleKind& kind : file.particles)
      kinds.push_back({{"type", kind.type},
                       {"name", snapshot::name_of_type(kind.type)},
                       {"count", kind.count},
                       {"mass", kind.mass != 0 && std::isfinite(kind.mass) ? Json(kind.mass) : Json()}});
  }
  Json stated = Json::object();
  for (const auto& [name, value] : file.stated)
    if (value != 0 && std::isfinite(value)) stated[name] = value;
  if (!stated.empty()) described["stated"] = std::move(stated);
  if (file.snapshot)
    described["snapshot"] = {{"files", file.snapshot->files},
                             {"points", file.snapshot->points},
                             {"box", {file.box.x, file.box.y, file.box.z}}};
  return described;
}

// The tiles that `triangulate` would make. The sample is taken after the filters; counts of headers are not.
struct Forecast {
  std::uint64_t limit = 0;
  std::uint32_t tiles = 1;
  bool from_sample = true;  // else from what the headers say
  Bounds sampled;
  Estimate cost;
};

// A sample of objects on other machines costs a good part of their bytes, where their headers cost some kilobytes.
bool has_objects(const Cloud& cloud) {
  return std::any_of(cloud.files().begin(), cloud.files().end(),
                     [](const FileInfo& file) { return names_object(file.path.string()); });
}

void forecast_by_headers(const JobOptions& options, const Cloud& cloud, std::uint64_t points, Forecast& made) {
  made.from_sample = false;
  for (const auto& file : cloud.files())
    if (file.bounds) made.sampled.add(*file.bounds);
  const std::uint64_t tiles = options.tiles > 0 ? options.tiles : points / std::max<std::uint64_t>(1, made.limit) + 1;
  made.tiles = static_cast<std::uint32_t>(std::min<std::uint64_t>(tiles, Partition::tiles_max));
}

// `read`: all points were read, so reading some of them again costs nothing.
Result<Forecast> forecast(const JobOptions& options, const Cloud& cloud, std::uint64_t points, bool read) {
  constexpr std::size_t sample_wanted = 100'000;
  Forecast made;
  BOOST_OUTCOME_TRY(limit, tile_limit(options, cloud));
  made.limit = limit;
  std::vector<Point> sample;
  if (has_objects(cloud) && !read) {
    forecast_by_headers(options, cloud, points, made);
  } else {
    BOOST_OUTCOME_TRY(taken, sample_cloud(cloud, sample_wanted));
    sample = std::move(taken);
  }
  for (const auto& p : sample) made.sampled.add(p);
  const int dimension = options.cloud.dimension;
  if (!sample.empty()) {
    made.tiles =
        (options.tiles > 0 ? Partition::build_tiles(options.partition, dimension, sample, made.sampled, options.tiles)
                           : Partition::build(options.partition, dimension, sample, made.sampled, points, limit))
            .tiles();
  }
  made.cost =
      estimate(dimension, options.kernel, kind_of_tiles(options.store, points), points, limit, options.neighbors,
               row_bytes(cloud.schema()), {.memory_bytes = options.memory_bytes, .threads = options.threads});
  for (const auto& file : cloud.files())
    if (!file.packing.empty()) made.cost.temporary_bytes += file.content_bytes;
  return made;
}

Result<Json> count_points(const std::vector<std::string>& inputs, JobOptions options, const Cloud& cloud,
                          const std::stop_token& stop) {
  options.cloud.attributes = described_attributes(cloud);
  BOOST_OUTCOME_TRY(counted, open_cloud(inputs, options, stop));
  return describe_points(counted);
}

Result<std::string> describe_together(const std::vector<std::string>& inputs, JobOptions options,
                                      const DescribeOptions& how, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(cloud, open_cloud(inputs, options, stop));
  Json counted;
  if (how.statistics) {
    BOOST_OUTCOME_TRY(described, count_points(inputs, options, cloud, stop));
    counted = std::move(described);
  }
  // If all points were read, they are counted, and those that the filters keep: nothing is left to guess.
  const auto of_count = [&](const char* key) { return counted.at(key).get<std::uint64_t>(); };
  const auto points = counted.is_null() ? expected_points(cloud.files()) : of_count("points");
  const auto kept = counted.is_null() ? points : points - of_count("invalid") - of_count("filtered");
  BOOST_OUTCOME_TRY(expected, forecast(options, cloud, kept, !counted.is_null()));
  const auto& cost = expected.cost;
  Json files = Json::array();
  for (const auto& file : cloud.files()) {
    files.push_back(to_json(file));
    BOOST_OUTCOME_TRY(result, result_of(file));
    files.back()["result"] = std::move(result);
  }
  Json phases = Json::object();
  for (const auto& [phase, bytes] : cost.phases.bytes) phases[name_of(phase)] = bytes;
  return written({{"files", files},
                  {"points", points},
                  {"statistics", counted},
                  {"sampled", expected.from_sample},
                  {"sampled_bounds", to_json(expected.sampled)},
                  {"crs", cloud.crs()},
                  {"crs_name", crs_title(cloud.crs())},
                  {"warnings", cloud.warnings()},
                  {"dimension", options.cloud.dimension},
                  {"partition", name_of(options.partition)},
                  {"max_points_per_tile", expected.limit},
                  {"tiles", expected.tiles},
                  {"threads", options.threads},
                  {"memory_budget_bytes", options.memory_bytes},
                  {"estimate",
                   {{"cells", cost.cells},
                    {"memory_bytes", cost.memory_bytes},
                    {"phases", phases},
                    {"tiles_whole", cost.phases.whole},
                    {"result_bytes", cost.result_bytes},
                    {"temporary_bytes", cost.temporary_bytes},
                    {"seconds", cost.seconds}}}},
                 how.json);
}

// What is wrong with some of many files must not hide the others.
Described describe_each(const std::vector<std::string>& inputs, const JobOptions& options, const DescribeOptions& how,
                        const Error& all) {
  Spool spool("", {});
  const InputQuestion question{
      .patterns = inputs, .list = options.cloud.input_list, .recursive = options.cloud.recursive};
  const auto names = find_inputs(question, spool);
  if (!names || names.value().size() < 2) return {.error = all};
  Described described;
  Json files = Json::array();
  std::size_t odd = 0;
  for (const auto& name : names.value()) {
    JobOptions alone = options;
    alone.cloud.input_list.clear();
    const auto cloud = name.standard_input ? Result<Cloud>(all) : open_cloud({name.path}, alone);
    if (cloud) {
      files.push_back(to_json(cloud.value().files().front()));
      continue;
    }
    ++odd;
    const std::string sentence = render(name.explained(cloud.error()).where, how.names);
    files.push_back({{"path", name.path}, {"error", sentence}});
  }
  described.text = written({{"files", files}}, how.json);
  if (odd == 0) {
    described.error = all;
  } else {
    described.error = error(all.code, std::to_string(odd) + " of " + std::to_string(names.value().size()) +
                                          " files cannot be triangulated, the first: " + all.where);
  }
  return described;
}

}  // namespace

Described describe(const std::vector<std::string>& what, JobOptions options, const DescribeOptions& how,
                   const std::stop_token& stop) {
  bool folder = false;
  for (const auto& path : what) {
    const auto result = is_result_folder(path);
    if (!result) return {.error = result.error()};
    folder = folder || result.value();
  }
  if (folder && (what.size() > 1 || !options.cloud.input_list.empty()))
    return {.error = error(Errc::usage, "give one result folder, or input files, not both")};
  auto described =
      folder ? describe_result(what.front(), how.json, how.counters) : describe_together(what, options, how, stop);
  if (described) return {.text = std::move(described).value()};
  const auto code = described.error().code;
  if (folder || !how.names || (code != Errc::bad_input && code != Errc::io)) return {.error = described.error()};
  return describe_each(what, options, how, described.error());
}

}  // namespace tessera
