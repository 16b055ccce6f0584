#include "src/delaunay/update/update_stages.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/update_names.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/delaunay/update/anew.h"
#include "src/delaunay/update/changed_program.h"
#include "src/delaunay/update/holes_program.h"
#include "src/delaunay/update/known_in_change.h"
#include "src/delaunay/update/update_folder.h"
#include "src/tiling/budget/budget.h"
#include "src/tiling/partition.h"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

template <class Program>
class ProgramsOf final : public TilePrograms {
 public:
  explicit ProgramsOf(std::shared_ptr<const UpdateSetting> setting) : setting_(std::move(setting)) {}
  std::unique_ptr<TileProgram> program_of(TileId tile) const override {
    return std::make_unique<Program>(tile, setting_);
  }

 private:
  std::shared_ptr<const UpdateSetting> setting_;
};

std::shared_ptr<const KnownFromStart> around_of(const TileSource& source, const UpdatePlan& plan,
                                                const Partition& partition) {
  std::vector<TileId> tiles;
  for (const TileEntry& entry : source.manifest().tiles) tiles.push_back(entry.tile);
  for (const auto& [tile, points] : plan.added) tiles.push_back(tile);
  return std::make_shared<const KnownFromStart>(known_in_change(partition, tiles));
}

Result<std::shared_ptr<const UpdatePlan>> read_change(const ResultInput& input, const UpdateJob& job,
                                                      const Partition& partition) {
  const auto file = update_change_file(input.run);
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  auto plan = checksum_text(checksum(bytes)) == job.change ? update_plan_of(bytes) : std::nullopt;
  const bool fits = plan && (plan->added.empty() || plan->added.rbegin()->first.value < partition.tiles());
  if (!fits) return error(Errc::corrupt, file.string() + ": is damaged");
  return std::make_shared<const UpdatePlan>(std::move(*plan));
}

Result<AnewStart> read_anew(const std::filesystem::path& run, const UpdateJob& job) {
  const auto file = update_anew_file(run);
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  auto start = checksum_text(checksum(bytes)) == job.anew ? anew_start_of(bytes) : std::nullopt;
  if (!start) return error(Errc::corrupt, file.string() + ": is damaged");
  return std::move(*start);
}

}  // namespace

std::string to_json(const UpdateJob& job) {
  Json json{{"job", kind_of_update}, {"number", job.number}, {"result", job.result}, {"tiles", job.tiles},
            {"change", job.change},  {"writes", job.writes}, {"anew", job.anew},     {"added", Json::array()}};
  for (const auto& [tile, points] : job.added) json["added"].push_back(Json::array({tile.value, points}));
  return json_text(json) + "\n";
}

Result<UpdateJob> read_update_job(std::span<const std::byte> bytes, const std::string& name) {
  try {
    const Json json = parse_ordered_json(as_text(bytes));
    UpdateJob job;
    json.at("number").get_to(job.number);
    json.at("result").get_to(job.result);
    json.at("tiles").get_to(job.tiles);
    json.at("change").get_to(job.change);
    json.at("writes").get_to(job.writes);
    json.at("anew").get_to(job.anew);
    for (const Json& of_tile : json.at("added"))
      job.added[TileId{of_tile.at(0).get<std::uint32_t>()}] = of_tile.at(1).get<std::uint64_t>();
    return job;
  } catch (const Json::exception&) {
    return error(Errc::corrupt, name + ": is damaged, or not the plan of a change");
  }
}

Result<std::vector<std::shared_ptr<const TilePrograms>>> UpdateStages::programs(const ResultInput& given) const {
  ResultInput input = given;
  input.source = given.source.without_columns();
  BOOST_OUTCOME_TRY(job, read_update_job(input.plan, plan_file(input.run).string()));
  const Manifest& manifest = input.source.manifest();
  BOOST_OUTCOME_TRY(partition, Partition::from_json(manifest.partition));
  BOOST_OUTCOME_TRY(plan, read_change(input, job, partition));
  for (const auto& folder :
       {update_told_folder(input.run), update_ends_folder(input.run), tiles_folder(update_result_folder(input.run))}) {
    BOOST_OUTCOME_TRYV(make_directories(folder));
  }
  UpdateSetting setting{.dimension = manifest.dimension,
                        .plan = plan,
                        .around = {},
                        .store = std::make_shared<UpdateFolder>(input, plan, job.writes),
                        .result = input.source.folder().string(),
                        .stop = input.stop};
  std::vector<std::shared_ptr<const TilePrograms>> programs;
  if (!job.anew.empty()) {
    if (holes_) return error(Errc::corrupt, plan_file(input.run).string() + ": is damaged");
    BOOST_OUTCOME_TRY(start, read_anew(input.run, job));
    BOOST_OUTCOME_TRY(anew, anew_programs(input, 0, plan, partition, std::move(start), setting.store));
    programs.push_back(anew);
    return programs;
  }
  setting.around = around_of(input.source, *plan, partition);
  const auto shared = std::make_shared<const UpdateSetting>(std::move(setting));
  if (holes_) programs.push_back(std::make_shared<ProgramsOf<HolesProgram>>(shared));
  programs.push_back(std::make_shared<ProgramsOf<ChangedProgram>>(shared));
  return programs;
}

// Tiles that a stage has left without a file come to its end again, which takes no time.
Result<std::vector<TileReceipt>> UpdateStages::stored(const std::filesystem::path& run, std::uint32_t stage) const {
  BOOST_OUTCOME_TRY(tiles, tiles_in(stage + 1 < count() ? update_told_folder(run) : update_ends_folder(run)));
  std::vector<TileReceipt> stored;
  for (const TileId tile : tiles) stored.push_back({tile, {}});
  return stored;
}

// A tile is read, which may rebuild its cells, and its points are then triangulated.
std::uint64_t UpdateStages::work_bytes(const TileSource& source, std::size_t i) const {
  const TileEntry& entry = source.entry(i);
  const int dimension = source.manifest().dimension;
  const std::uint64_t corners = static_cast<std::uint64_t>(dimension) + 1;
  const std::uint64_t mesh =
      entry.cells * (8 * corners + 2) + entry.points * (sizeof(Point) + 14 + row_bytes(source.manifest().schema));
  return std::max(source.work_bytes(i) + mesh, budget::tile_working_bytes(dimension, KernelKind::flat, entry.points));
}

Result<std::vector<std::uint64_t>> UpdateStages::weights(const TileSource& source, const std::filesystem::path& run,
                                                         std::span<const std::byte> plan) const {
  BOOST_OUTCOME_TRY(job, read_update_job(plan, plan_file(run).string()));
  if (!job.anew.empty()) {
    BOOST_OUTCOME_TRY(start, read_anew(run, job));
    return std::move(start.points);
  }
  BOOST_OUTCOME_TRY(partition, Partition::from_json(source.manifest().partition));
  auto weights = weights_of(source);
  weights.resize(partition.tiles());
  for (const auto& [tile, points] : job.added) {
    if (tile.value >= weights.size()) return error(Errc::corrupt, plan_file(run).string() + ": is damaged");
    weights[tile.value] += points;
  }
  return weights;
}

void UpdateStages::adjust(ScheduleOptions& schedule, const TileSource& source) const {
  const int dimension = source.manifest().dimension;
  schedule.unbuilt_bytes = 4096;  // the program and the counters of a tile without a triangulation take less
  schedule.mail_growth =
      static_cast<double>(budget::foreign_point_bytes(dimension, KernelKind::flat)) / sizeof(SharedPoint);
  schedule.sleep_percent = budget::sleep_percent(KernelKind::flat);
  schedule.wake_percent = budget::wake_percent(KernelKind::flat);
}

}  // namespace tessera
