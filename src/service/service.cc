#include "src/service/service.h"

#include <algorithm>
#include <utility>

#include "actors/cluster/seat.h"
#include "actors/engine/engine.h"
#include "src/base/files/names.h"
#include "src/job/engine_steps.h"
#include "src/service/data_folder.h"
#include "src/service/data_format.h"
#include "src/service/health.h"
#include "src/service/inputs/inputs.h"
#include "src/service/jobs/jobs.h"
#include "src/service/jobs/upkeep.h"
#include "src/service/jobs/workers.h"
#include "src/service/live/live_results.h"
#include "src/service/nodes.h"
#include "src/service/problem.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/processes.h"
#include "src/service/processes/table.h"
#include "src/service/questions/questions.h"
#include "src/service/results/results.h"

namespace tessera::service {
namespace {

constexpr std::chrono::hours part_time{24};  // for partial uploads: nobody continues one that is this old

JobShare share_of(const ServiceOptions& options) {
  const auto running = std::max(1U, options.limits.running);
  return {(options.threads + running - 1) / running, options.memory_bytes / running};
}

// Questions use memory in addition to that of jobs, which is most of the machine's: an eighth of it.
QuestionLimits limits_of_questions(const ServiceOptions& options) {
  return {.memory_bytes = options.memory_bytes / 8, .threads = std::max(1U, options.threads / 2)};
}

// Jobs share what live results leave.
Status reserve_for_live(ServiceOptions& options) {
  if (options.live.empty()) return success();
  if (options.live_memory_bytes == 0) options.live_memory_bytes = options.memory_bytes / 2;
  if (options.live_memory_bytes >= options.memory_bytes)
    return error(Errc::usage, "live results would have all of the daemon's memory: give them less than the daemon has");
  options.memory_bytes -= options.live_memory_bytes;
  return success();
}

Result<std::unique_ptr<Engine>> open_engine(const ServiceOptions& options) {
  if (!options.cluster) return std::make_unique<Engine>(options.threads, options.memory_bytes, kinds_of_stages());
  auto cluster = *options.cluster;
  cluster.jobs_at_once = options.limits.running;
  BOOST_OUTCOME_TRY(identity, data_identity(options.data));
  cluster.shared = identity;
  cluster.data = options.data;
  return Engine::join(options.threads, options.memory_bytes, std::make_unique<Seat>(std::move(cluster)),
                      kinds_of_stages());
}

}  // namespace

struct Service::Impl {
  Impl(ServiceOptions given, std::unique_ptr<DataFolder> held, Roots opened_roots,
       std::unique_ptr<Events> opened_events, std::unique_ptr<Engine> opened_engine);
  // Starts the threads.
  void begin();
  JobTableHooks table_hooks();
  WorkersHooks workers_hooks();
  UpkeepOptions upkeep_options();
  LiveResultsOptions live_options() const;
  Result<std::string> owner_of_result(const std::string& name);
  std::string job_that_changes(const std::string& result);
  Status drop_files(const proto::JobRecord& job);
  Result<std::filesystem::path> publish(const proto::JobRecord& job);

  const ServiceOptions options;
  const JobShare share;
  const std::unique_ptr<DataFolder> data_folder;
  const Roots roots;
  const std::unique_ptr<Events> events;
  const std::unique_ptr<Engine> engine;
  ResultFolders folders;
  JobTable table;
  Uploads uploads;
  RegionClouds clouds;
  const Workshop shop;
  LiveResults live;
  Admission admission;
  Questions questions;
  Jobs jobs;
  Results results;
  Processes processes;
  Inputs inputs;
  Nodes nodes;
  // Made by begin(). The threads end first.
  std::optional<Upkeep> upkeep;
  std::optional<ServiceHealth> health;
  std::optional<Workers> workers;
};

Service::Impl::Impl(ServiceOptions given, std::unique_ptr<DataFolder> held, Roots opened_roots,
                    std::unique_ptr<Events> opened_events, std::unique_ptr<Engine> opened_engine)
    : options(std::move(given)),
      share(share_of(options)),
      data_folder(std::move(held)),
      roots(std::move(opened_roots)),
      events(std::move(opened_events)),
      engine(std::move(opened_engine)),
      folders(options.data, data_folder->desk_of_results()),
      table(options.data, data_folder->desk(), *events, options.limits, table_hooks()),
      uploads(options.data, {.bytes = options.limits.upload_bytes, .reserve_bytes = options.limits.reserve_bytes},
              data_folder->desk_of_uploads()),
      clouds(options.memory_bytes / 8),
      shop{*engine, roots, folders, options.data, options.limits, share, clouds, options.data_lease},
      live(folders, live_options(), [this](const std::string& name) { return owner_of_result(name); }),
      admission(table, folders, [this](std::string_view name) { return live.find(name) != nullptr; }),
      questions(folders, options.data, limits_of_questions(options), &live),
      jobs(table, admission, folders),
      results(folders, table, jobs, admission, questions),
      processes(shop, admission),
      inputs(roots, options.uploads ? &uploads : nullptr),
      nodes(*engine, table, options.cluster.has_value(), options.memory_bytes) {}

void Service::Impl::begin() {
  upkeep.emplace(table, upkeep_options());
  const auto certificate_end_s =
      options.cluster ? std::optional<std::int64_t>(options.cluster->certificate_end_s) : std::nullopt;
  health.emplace(HealthSources{*engine, *data_folder, table, *upkeep, questions, options.data, options.memory_bytes,
                               certificate_end_s});
  workers.emplace(table, workers_hooks(), options.limits.running);
}

JobTableHooks Service::Impl::table_hooks() {
  return {.warn = options.log,
          .note = options.note,
          .named = [this](const std::string& sentence) { return roots.named(sentence); },
          .drop = [this](const proto::JobRecord& job) { return drop_files(job); }};
}

Status Service::Impl::drop_files(const proto::JobRecord& job) {
  BOOST_OUTCOME_TRYV(folders.drop_unfinished(job.id()));
  if (!export_output(job.inputs())) return success();
  return folders.drop_unfinished_export(job.triangulation(), job.id());
}

WorkersHooks Service::Impl::workers_hooks() {
  return {.work = [this](const JobWork& work) { return do_work(shop, work); },
          .publish = [this](const proto::JobRecord& job) -> Reply<std::filesystem::path> {
            auto replaced = publish(job);
            if (!replaced) return problem_of(replaced.error());
            return std::move(replaced).value();
          },
          .discard = [](const std::filesystem::path& folder) { return ResultFolders::discard(folder); },
          .gathering = [this] { return engine->gathering(); },
          .bounds = [this] { return bounds_of_job(options.limits, options.data); }};
}

Result<std::filesystem::path> Service::Impl::publish(const proto::JobRecord& job) {
  std::filesystem::path replaced;
  if (makes_result(job.inputs())) {
    BOOST_OUTCOME_TRY(old, folders.publish(job.id(), job.triangulation(), overwrites(job.inputs())));
    replaced = old;
    if (!replaced.empty()) questions.close(job.triangulation());
  }
  if (changes_result(job.inputs())) questions.renew(job.triangulation());
  if (export_output(job.inputs())) {
    BOOST_OUTCOME_TRYV(folders.publish_export(job));
  }
  return replaced;
}

UpkeepOptions Service::Impl::upkeep_options() {
  // Tiles that nodes have triangulated outlive the coordinator's process. Without nodes only stored tiles do.
  const bool nodes_keep = options.cluster.has_value();
  return {.retention = std::chrono::seconds(options.retention_s),
          .lasting = [nodes_keep](const Progress& progress) -> std::uint64_t {
            return progress.tiles_stored + (nodes_keep ? progress.tiles_triangulated.load() : 0);
          },
          .each_minute =
              [this] {
                if (!options.uploads) return;
                for (const auto& line : uploads.expire(std::chrono::system_clock::now() - part_time)) table.warn(line);
              }};
}

LiveResultsOptions Service::Impl::live_options() const {
  return {.names = options.live,
          .memory_bytes = options.live_memory_bytes,
          .log_bytes_max = options.live_log_bytes,
          .threads = options.threads,
          .warn = options.log,
          .note = options.note};
}

Result<std::string> Service::Impl::owner_of_result(const std::string& name) {
  const std::lock_guard lock(table.mutex);
  return admission.owner_of_result(name);
}

std::string Service::Impl::job_that_changes(const std::string& result) {
  const std::lock_guard lock(table.mutex);
  for (const auto& id : table.active) {
    const proto::JobRecord& record = table.jobs.at(id)->record;
    const bool changes = makes_result(record.inputs()) || changes_result(record.inputs());
    if (changes && record.triangulation() == result) return id;
  }
  return {};
}

Result<std::unique_ptr<Service>> Service::open(ServiceOptions options) {
  const auto refuse = [](const std::string& what) { return error(Errc::usage, what); };
  if (options.data.empty()) return refuse("no data folder is given");
  if (options.limits.running < 1) return refuse("at least one job must be allowed to run");
  if (options.threads < 1) return refuse("at least one thread is needed");
  BOOST_OUTCOME_TRYV(reserve_for_live(options));
  if (options.memory_bytes / options.limits.running < (std::uint64_t{64} << 20))
    return refuse(
        "each job would have less than 64 MiB of memory: give the daemon more memory, or let fewer jobs run at once");
  options.data = std::filesystem::absolute(options.data).lexically_normal();
  BOOST_OUTCOME_TRYV(check_apart(options.data, options.roots));
  BOOST_OUTCOME_TRY(held, DataFolder::hold(options));
  BOOST_OUTCOME_TRY(roots, Roots::open(options.roots, options.uploads ? uploads_folder(options.data) : ""));
  BOOST_OUTCOME_TRY(events, Events::open(event_numbers_file(options.data), held->desk(), options.log));
  BOOST_OUTCOME_TRY(engine, open_engine(options));
  auto impl = std::make_unique<Impl>(std::move(options), std::move(held), std::move(roots), std::move(events),
                                     std::move(engine));
  BOOST_OUTCOME_TRY(known, impl->table.load());
  BOOST_OUTCOME_TRYV(impl->folders.open(known));
  BOOST_OUTCOME_TRYV(impl->questions.open());
  if (impl->options.uploads) {
    BOOST_OUTCOME_TRYV(impl->uploads.open());
  }
  impl->live.open([&](const std::string& name) { return impl->job_that_changes(name); });
  impl->begin();
  return std::unique_ptr<Service>(new Service(std::move(impl)));
}

Service::Service(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Service::~Service() = default;

Backend Service::backend() {
  return {impl_->processes, impl_->jobs,  impl_->results, impl_->questions,
          impl_->inputs,    impl_->nodes, *impl_->health, impl_->live};
}
ProcessesBackend& Service::processes() { return impl_->processes; }
JobsBackend& Service::jobs() { return impl_->jobs; }
ResultsBackend& Service::results() { return impl_->results; }
QuestionsBackend& Service::questions() { return impl_->questions; }
InputsBackend& Service::inputs() { return impl_->inputs; }
NodesBackend& Service::nodes() { return impl_->nodes; }
LiveBackend& Service::live() { return impl_->live; }
const HealthBackend& Service::health() const { return *impl_->health; }

}  // namespace tessera::service
