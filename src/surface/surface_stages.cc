#include "src/surface/surface_stages.h"

#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/surface/folder_store.h"

namespace tessera::surface {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Point& at) { return Json::array({at.x, at.y, at.z}); }
Point point_of(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Json json_of(const SensorOptions& sensors) {
  Json json{{"kind", static_cast<int>(sensors.kind)},
            {"else_above", sensors.else_above},
            {"positions", Json::array()},
            {"track", Json()}};
  for (const Point& at : sensors.positions) json["positions"].push_back(json_of(at));
  if (!sensors.track) return json;
  json["track"] = sensors.track->to_csv();
  return json;
}

SensorOptions sensors_of(const Json& json) {
  SensorOptions sensors;
  const int kind = json.at("kind");
  if (kind < 0 || kind > static_cast<int>(SensorOptions::Kind::track))
    throw Json::other_error::create(501, "the kind of sensors is not known", nullptr);
  sensors.kind = static_cast<SensorOptions::Kind>(kind);
  json.at("else_above").get_to(sensors.else_above);
  for (const Json& at : json.at("positions")) sensors.positions.push_back(point_of(at));
  const Json& track = json.at("track");
  if (track.is_null()) return sensors;
  auto read = Track::parse(track.get<std::string>(), "the track");
  if (!read) throw Json::other_error::create(501, "no track", nullptr);
  sensors.track = std::make_shared<const Track>(std::move(read).value());
  return sensors;
}

SurfacePlan plan_of(const Json& json) {
  SurfacePlan plan;
  const Json& energy = json.at("energy");
  Energy& to = plan.options.energy;
  energy.at("lambda").get_to(to.lambda);
  energy.at("alpha").get_to(to.alpha);
  energy.at("sigma").get_to(to.sigma);
  const Json& length = energy.at("ray_length");
  to.ray_length = length.is_null() ? std::numeric_limits<double>::infinity() : length.get<double>();
  json.at("lower_inside").get_to(plan.options.rule.lower_inside);
  json.at("unknown_inside").get_to(plan.options.rule.unknown_inside);
  json.at("below").get_to(plan.options.boundary.below);
  if (!json.at("trim").is_null()) plan.options.boundary.trim = json.at("trim").get<double>();
  json.at("splits").get_to(plan.options.splits);
  json.at("prove").get_to(plan.options.prove);
  json.at("together").get_to(plan.options.together);
  plan.sensors = sensors_of(json.at("sensors"));
  json.at("result").get_to(plan.result);
  json.at("tiles").get_to(plan.tiles);
  json.at("number").get_to(plan.number);
  return plan;
}

}  // namespace

std::string to_json(const SurfacePlan& plan) {
  const StepOptions& options = plan.options;
  const Json json{{"job", kind_of_surface},
                  {"number", plan.number},
                  {"result", plan.result},
                  {"tiles", plan.tiles},
                  {"energy",
                   {{"lambda", options.energy.lambda},
                    {"alpha", options.energy.alpha},
                    {"sigma", options.energy.sigma},
                    {"ray_length", options.energy.ray_length}}},  // null when it is infinite
                  {"lower_inside", options.rule.lower_inside},
                  {"unknown_inside", options.rule.unknown_inside},
                  {"below", options.boundary.below},
                  {"trim", options.boundary.trim ? Json(*options.boundary.trim) : Json()},
                  {"splits", options.splits},
                  {"prove", options.prove},
                  {"together", options.together},
                  {"sensors", json_of(plan.sensors)}};
  return json_text(json) + "\n";
}

Result<SurfacePlan> read_plan(std::span<const std::byte> bytes, const std::string& name) {
  try {
    return plan_of(parse_ordered_json(as_text(bytes)));
  } catch (const Json::exception&) {
    return error(Errc::corrupt, name + ": is damaged, or not the plan of a surface");
  }
}

Result<std::vector<std::shared_ptr<const TilePrograms>>> SurfaceStages::programs(const ResultInput& input) const {
  BOOST_OUTCOME_TRY(plan, read_plan(input.plan, plan_file(input.run).string()));
  const Manifest& manifest = input.source.manifest();
  BOOST_OUTCOME_TRY(sensors, Sensors::make(plan.sensors, manifest.schema, manifest.bounds));
  StepInput all{.options = plan.options,
                .sensors = std::move(sensors),
                .solidity = Solidity(manifest.schema),
                .tiles = {},
                .cells = manifest.cells,
                .stop = input.stop};
  for (std::size_t i = 0; i < input.source.tiles(); ++i) all.tiles.push_back(input.source.entry(i).tile);
  BOOST_OUTCOME_TRY(opened, FolderStore::open(input));
  const std::shared_ptr<FolderStore> store = std::move(opened);
  const auto shared = std::make_shared<const StepInput>(std::move(all));
  std::vector<std::shared_ptr<const TilePrograms>> programs;
  for (std::uint32_t step = 0; step < steps_count; ++step)
    programs.push_back(programs_of(static_cast<SurfaceStageId>(step), shared, store));
  return programs;
}

Result<std::vector<TileReceipt>> SurfaceStages::stored(const std::filesystem::path& run, std::uint32_t stage) const {
  BOOST_OUTCOME_TRY(tiles, tiles_kept(run, output_of(static_cast<SurfaceStageId>(stage))));
  std::vector<TileReceipt> stored;
  for (const TileId tile : tiles) stored.push_back({tile, {}});
  return stored;
}

std::uint64_t SurfaceStages::work_bytes(const TileSource& source, std::size_t i) const {
  return std::max(source.work_bytes(i), source.entry(i).cells * bytes_a_cell);
}

}  // namespace tessera::surface
