#include "src/service/work.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "src/base/option.h"
#include "src/export/export.h"
#include "src/files/checksum.h"
#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/whole_file.h"
#include "src/job/describe.h"
#include "src/job/estimate.h"
#include "src/job/job.h"
#include "src/job/job_report.h"
#include "src/job/open_cloud.h"
#include "src/job/result_folder.h"
#include "src/report/human.h"
#include "src/report/summary.h"
#include "src/service/costs.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/tileset/tileset.h"
#include "src/verify/verify.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* tileset_format = "3dtiles";  // of exports, beside those of src/export

// Of a result that was complete when its job went on.
Result<JobSummary> summary_of_stored(const Workshop& shop, const JobOptions& options, const proto::JobRecord& job) {
  const auto unfinished = shop.results.unfinished(job.id());
  std::error_code failed;
  const auto folder =
      std::filesystem::exists(unfinished, failed) ? unfinished : shop.results.folder(job.triangulation());
  BOOST_OUTCOME_TRY(manifest, read_manifest(folder));
  auto summary = summary_of(options, job.triangulation(), manifest, RunSummary{});
  summary.duplicates = manifest.duplicates;
  if (manifest.digest) summary.digest = digest_text(*manifest.digest);
  for (const auto& [phase, seconds] : manifest.seconds) {
    summary.seconds.emplace_back(phase, seconds);
    summary.total_s += seconds;
  }
  return summary;
}

Reply<JobDone> done_with(JobSummary summary, const proto::JobRecord& job) {
  summary.out = job.triangulation();
  return JobDone{summary_json(summary) + "\n", summary.points_read, summary.seconds};
}

// The problem of a failed triangulation, and what stays of it.
proto::Problem failed_with(const Error& error, const std::optional<proto::Problem>& refused, ResultFolder& folder,
                           const Workshop& shop, const JobWork& work) {
  if (error.code == Errc::interrupted) {
    work.log(folder.interrupted() ? "interrupted; what is done stays"
                                  : "interrupted before there was anything to keep");
    return problem_of(error);
  }
  folder.abandon();
  // A run that went on and failed for want of room or memory can go on once there is some; no other would end well.
  if (error.code != Errc::io && error.code != Errc::memory) {
    const auto path = shop.results.unfinished(work.job.id());
    if (const auto left = remove_tree(path)) work.log(path.string() + ": cannot be removed: " + left.message());
  }
  return refused ? *refused : problem_of(error);
}

Reply<JobDone> triangulate(const Workshop& shop, const JobWork& work) {
  const auto& job = work.job;
  const auto& inputs = job.inputs().triangulate();
  auto options = job_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  if (shop.limits.running > 0 && !inputs.has_threads())
    options.value().threads = std::max(options.value().threads, shop.engine.threads() / shop.limits.running);
  options.value().command = Results::command_of(job.id(), process_of(job.inputs()));
  options.value().log = work.log;
  options.value().cloud.spool_bytes_max = unpacked_max(shop.limits, shop.data);
  // Complete, and given its name, just before an earlier process ended.
  const auto path = shop.results.unfinished(job.id());
  std::error_code failed;
  if (!std::filesystem::exists(path, failed) && job.starts() > 1 &&
      shop.results.made_by(job.triangulation(), job.id())) {
    auto summary = summary_of_stored(shop, options.value(), job);
    if (!summary) return problem_of(summary.error());
    return done_with(std::move(summary).value(), job);
  }
  auto folder = ResultFolder::inspect(path, true, false);
  if (!folder) return problem_of(folder.error());
  std::optional<proto::Problem> refused;
  const auto open = [&](JobOptions& opened, const std::stop_token& stop) -> Result<Cloud> {
    BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
    BOOST_OUTCOME_TRY(cloud, open_cloud(files, opened, stop));
    proto::Estimate estimate;
    if (!folder.value().resuming()) refused = check_costs(cloud, opened, shop.limits, shop.data, estimate);
    if (refused) return error(Errc::memory, refused->detail());
    for (const auto& warning : cloud.warnings()) work.log("warning: " + warning);
    return std::move(cloud);
  };
  if (folder.value().resuming()) work.log("goes on with what is there");
  auto summary = run_job(shop.engine, options.value(), open, folder.value(), work.progress, work.stop);
  if (!summary) return failed_with(summary.error(), refused, folder.value(), shop, work);
  if (summary.value()) return done_with(*std::move(summary).value(), job);
  auto stored = summary_of_stored(shop, options.value(), job);
  if (!stored) return problem_of(stored.error());
  return done_with(std::move(stored).value(), job);
}

Reply<JobDone> verify(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().verify();
  auto options = verify_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  options.value().scratch = work.scratch;
  if (const auto problem = check_verify(shop, inputs)) return *problem;
  const auto report = tessera::verify(shop.results.folder(inputs.triangulation()), options.value(), work.stop);
  if (!report) return problem_of(report.error());
  const auto& found = report.value();
  for (const auto& passed : found.passed) work.log("ok  " + passed);
  return JobDone{to_json(found, inputs.triangulation()) + "\n", 0, {}};
}

// What an export has made in `folder`: where the result will have it, its bytes and checksum.
Result<Json> written_files(const std::filesystem::path& folder) {
  Json list = Json::array();
  std::vector<std::filesystem::path> folders{""};
  while (!folders.empty()) {
    const auto inside = std::move(folders.back());
    folders.pop_back();
    FolderReader reader(folder / inside);
    while (const char* name = reader.next()) {
      const auto path = inside / name;
      std::error_code failed;
      if (std::filesystem::is_directory(folder / path, failed)) {
        folders.push_back(path);
        continue;
      }
      BOOST_OUTCOME_TRY(sum, checksum_file(folder / path));
      list.push_back({{"path", (exports_folder("") / path).string()},
                      {"bytes", std::filesystem::file_size(folder / path, failed)},
                      {"xxh3", checksum_text(sum)}});
    }
    if (reader.error()) return io_error(folder / inside, "cannot be listed", reader.error().value());
  }
  return list;
}

// What `write` has made in the job's folder, or nothing.
template <class Write>
auto written_aside(const std::filesystem::path& folder, const JobWork& work, const Write& write) {
  auto made = [&]() -> decltype(write()) {
    if (const auto left = remove_tree(folder)) return io_error(folder, "cannot be removed", left.value());
    BOOST_OUTCOME_TRYV(make_directories(folder));
    return write();
  }();
  if (!made) {
    if (const auto left = remove_tree(folder)) work.log(folder.string() + ": cannot be removed: " + left.message());
    std::error_code others;
    std::filesystem::remove(folder.parent_path(), others);  // stays when anything is in it
  }
  return made;
}

// As a share of points that there may not be: a percentage for those who watch.
std::function<void(double)> percentage(const JobWork& work) {
  return [&work](double part) {
    work.progress.points_total = 100;
    work.progress.points_triangulated = static_cast<std::uint64_t>(part * 100);
  };
}

Reply<JobDone> export_tileset(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().export_();
  if (inputs.has_heights() || inputs.has_spatial_index())
    return problem(400, "format: 3dtiles takes neither heights nor spatial_index", Errc::usage);
  TilesetOptions options{.memory_bytes = shop.share.memory_bytes, .progress = percentage(work)};
  if (inputs.has_max_edge()) options.max_edge = inputs.max_edge();
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto made = written_aside(folder, work, [&] {
    return write_tileset(shop.results.folder(inputs.triangulation()), folder / inputs.output(), options, work.stop);
  });
  if (!made) return problem_of(made.error());
  Json outcome = Json::parse(to_json(made.value()));
  const auto document = tileset_file(exports_folder("") / inputs.output());
  outcome["output"] = inputs.output();
  outcome["written"] = Json::array({Json{{"path", document.string()}, {"bytes", made.value().bytes}}});
  return JobDone{outcome.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n", 0, {}};
}

Reply<JobDone> export_triangulation(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().export_();
  if (inputs.format() == tileset_format) return export_tileset(shop, work);
  auto options = export_options(inputs);
  if (!options) return problem_of(options.error());
  options.value().overwrite = true;  // of what an earlier attempt has left; the queue keeps what stands
  options.value().progress = percentage(work);
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto exported = written_aside(folder, work, [&] {
    // A name without an ending is a folder of files.
    return export_result(shop.results.folder(inputs.triangulation()), folder / inputs.output(), options.value(),
                         work.stop);
  });
  if (!exported) return problem_of(exported.error());
  auto written = written_files(folder);
  if (!written) return problem_of(written.error());
  const auto& made = exported.value();
  if (!made.note.empty()) work.log("note: " + made.note);
  Json outcome = Json::parse(to_json(made, made.path.filename().string()));
  outcome["written"] = std::move(written).value();
  return JobDone{outcome.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n", 0, {}};
}

}  // namespace

std::string process_of(const proto::Inputs& inputs) {
  switch (inputs.of_case()) {
    case proto::Inputs::kTriangulate:
      return "triangulate";
    case proto::Inputs::kVerify:
      return "verify";
    case proto::Inputs::kExport:
      return "export";
    case proto::Inputs::kInfo:
      return "info";
    case proto::Inputs::OF_NOT_SET:
      return "";
  }
  return "";
}

Result<std::optional<proto::Problem>> takes_too_long(const Workshop& shop, const proto::InfoInputs& inputs,
                                                     std::uint64_t points_max) {
  using Refused = std::optional<proto::Problem>;
  if (!inputs.triangulation().empty()) return Refused{};
  BOOST_OUTCOME_TRY(cloud, cloud_of(inputs));
  BOOST_OUTCOME_TRY(options, job_options(cloud, shop.share));
  BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
  BOOST_OUTCOME_TRY(packed, any_packed(files));
  if (packed) return Refused(needs_a_job("inputs: compressed files"));
  if (!inputs.stats()) return Refused{};
  BOOST_OUTCOME_TRY(opened, open_cloud(files, options));
  const auto points = expected_points(opened.files());
  if (points > points_max) return Refused(needs_a_job("inputs: " + grouped(points) + " points"));
  return Refused{};
}

Result<std::string> describe_inputs(const Workshop& shop, const proto::InfoInputs& inputs,
                                    const std::stop_token& stop) {
  DescribeOptions how{.json = true, .statistics = inputs.stats(), .names = field_name};
  if (!inputs.triangulation().empty()) {
    if (inputs.inputs_size() > 0) return error(Errc::usage, "inputs: give them, or a triangulation, not both");
    if (!check_name(inputs.triangulation()) || !shop.results.exists(inputs.triangulation()))
      return error(Errc::usage, "triangulation: there is none called '" + inputs.triangulation() + "'");
    return describe_result(shop.results.folder(inputs.triangulation()), true);
  }
  BOOST_OUTCOME_TRY(cloud, cloud_of(inputs));
  BOOST_OUTCOME_TRY(options, job_options(cloud, shop.share));
  BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
  options.cloud.spool_folder = shop.data;
  options.cloud.spool_bytes_max = unpacked_max(shop.limits, shop.data);

  auto described = describe(files, std::move(options), how, stop);
  if (described.error) return *described.error;
  return std::move(described.text);
}

std::optional<proto::Problem> check_verify(const Workshop& shop, const proto::VerifyInputs& inputs) {
  if (!inputs.against_cgal()) return std::nullopt;
  const auto manifest = shop.results.manifest(inputs.triangulation());
  if (!manifest) return problem_of(manifest.error());
  // CGAL's cells and vertices, and the sorted sets of both.
  const std::uint64_t vertex_bytes = manifest.value()->dimension == 3 ? 1'200 : 400;
  const auto bytes = manifest.value()->vertices * vertex_bytes;
  if (bytes <= shop.share.memory_bytes) return std::nullopt;
  return problem(422,
                 option("against-cgal") + ": " + grouped(manifest.value()->vertices) + " vertices need " +
                     human_bytes(bytes) + " of memory; a job has " + human_bytes(shop.share.memory_bytes) + " here",
                 Errc::memory);
}

Reply<JobDone> do_work(const Workshop& shop, const JobWork& work) {
  switch (work.job.inputs().of_case()) {
    case proto::Inputs::kTriangulate:
      return triangulate(shop, work);
    case proto::Inputs::kVerify:
      return verify(shop, work);
    case proto::Inputs::kExport:
      return export_triangulation(shop, work);
    default: {
      auto text = describe_inputs(shop, work.job.inputs().info(), work.stop);
      if (!text) return problem_of(text.error());
      return JobDone{std::move(text).value(), 0, {}};
    }
  }
}

}  // namespace tessera
