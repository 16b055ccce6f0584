#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/front/api/entry.h"
#include "src/front/api/errors.h"
#include "src/front/api/far_objects.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/triangulation_impl.h"
#include "src/front/api/triangulation_maker.h"
#include "src/input/bytes/objects.h"
#include "src/input/npy/array_source.h"
#include "src/job/describe.h"
#include "src/job/job.h"
#include "src/job/open_cloud.h"
#include "tessera/triangulation.h"

namespace tessera {
namespace {

void require(bool holds, const std::string& otherwise) {
  if (!holds) throw Failure(Cause::usage, otherwise);
}

JobProgress look(const Progress& progress) {
  JobProgress now;
  now.phase = name_of(progress.phase.load());
  now.points_total = progress.points_total;
  now.points_routed = progress.points_routed;
  now.points_triangulated = progress.points_triangulated;
  now.tiles_total = progress.tiles_total;
  now.tiles_triangulated = progress.tiles_triangulated;
  now.tiles_stored = progress.tiles_stored;
  now.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - progress.started).count();
  return now;
}

// A job that works in a thread of its own, so that the calling thread can report its progress.
class WatchedJob {
 public:
  WatchedJob(JobOptions job, const OpenCloud& open, ResultFolder folder, const std::stop_token& stop)
      : folder_(std::move(folder)),
        job_(std::move(job)),
        engine_(job_.threads, job_.memory_bytes),
        forward_(stop, [this] { stop_.request_stop(); }),
        outcome_(std::async(std::launch::async, [this, &open] {
          return run_job(engine_, job_, open, folder_, progress_, stop_.get_token());
        })) {}

  // Calls `progress` now and then until the job is done. `progress` may throw.
  void watch(const std::function<void(const JobProgress&)>& progress) {
    constexpr std::chrono::milliseconds interval(100);
    while (outcome_.wait_for(interval) != std::future_status::ready) call_back(progress, look(progress_));
  }
  // Waits for the end of the job, and returns the warnings about the input. Throws Failure if the job failed.
  std::vector<std::string> finish() {
    const auto summary = outcome_.get();
    if (!summary) {
      if (summary.error().code != Errc::interrupted) {
        keep_run_ = false;
        throw_failure(summary.error());
      }
      throw_failure(error(Errc::interrupted, "stopped, as was requested" +
                                                 (keep_run_ ? "; " + option("resume", "true") + " goes on" : "")));
    }
    return summary.value() ? summary.value()->warnings : std::vector<std::string>{};
  }
  // Stops the job after a failure of any kind. Leaves the unfinished run for --resume if the options ask for that, else
  // the folder as it was.
  void abandon() {
    stop_.request_stop();
    if (outcome_.valid()) outcome_.wait();
    keep_run_ ? static_cast<void>(folder_.abandon_unless_resumable()) : folder_.abandon();
  }
  JobProgress progress() const { return look(progress_); }

 private:
  ResultFolder folder_;
  JobOptions job_;
  bool keep_run_ = job_.resumable;
  Engine engine_;
  Progress progress_;
  std::stop_source stop_;
  std::stop_callback<std::function<void()>> forward_;
  std::future<Result<std::optional<JobSummary>>> outcome_;
};

// Runs a job to its end, with callbacks. If anything fails, the job has ended and the folder is clean before the
// exception leaves this function.
void run_watched(const TriangulationOptions& given, JobOptions job_options, const OpenCloud& open,
                 ResultFolder folder) {
  const auto& options = OptionsInside::of(given);
  auto job = guarded(
      [&] { return std::make_unique<WatchedJob>(std::move(job_options), open, std::move(folder), options.stop); });
  std::vector<std::string> warnings;
  try {
    if (options.progress) job->watch(options.progress);
    warnings = guarded([&] { return job->finish(); });
  } catch (...) {
    // In a child that the callback forked, the threads of the job do not exist, and the folder is the parent's. So the
    // job is leaked there.
    is_forked_within() ? static_cast<void>(job.release()) : job->abandon();
    throw;
  }
  const JobProgress last = job->progress();
  job.reset();
  call_back(options.progress, last);
  for (const auto& warning : warnings) call_back(options.warning, warning);
}

Triangulation make(const TriangulationOptions& given, const OpenCloud& open) {
  const Entry entry;
  const auto& options = OptionsInside::of(given);
  JobOptions job = guarded([&] { return job_options(given); });
  std::optional<TemporaryFolder> temporary;
  if (options.folder.empty()) temporary.emplace(value_or_throw(TemporaryFolder::make()));
  const auto path = temporary ? temporary->path() : options.folder;
  run_watched(given, std::move(job), open,
              value_or_throw(ResultFolder::inspect(path, options.resume, options.overwrite)));
  return TriangulationMaker::open(path, std::move(temporary));
}

void refuse_options_of_files(const TriangulationOptions& options) {
  const auto& asked = OptionsInside::of(options);
  require(asked.job.cloud.input_list.empty(),
          option("input-list") + ": the points are an array, so there are no input files");
  require(!asked.resume, option("resume") + ": an array may have changed since the first run; save it in a file");
}

}  // namespace

Triangulation TriangulationMaker::open(const std::filesystem::path& path, std::optional<TemporaryFolder> temporary) {
  auto source = value_or_throw(TileSource::open(path, Periods::known));
  std::shared_ptr<const TemporaryFolder> held;
  if (temporary) held = std::make_shared<const TemporaryFolder>(std::move(*temporary));
  return Triangulation(
      std::make_shared<const Triangulation::Impl>(Triangulation::Impl{std::move(source), std::move(held)}));
}

Triangulation triangulate(std::span<const double> coordinates, const TriangulationOptions& options) {
  const auto& asked = OptionsInside::of(options);
  const int dimension = asked.job.cloud.dimension;
  require(dimension == 2 || dimension == 3, option("dim") + ": must be 2 or 3 for an array");
  require(coordinates.size() % static_cast<std::size_t>(dimension) == 0,
          "the array: its length, " + std::to_string(coordinates.size()) + ", is not a multiple of the dimension, " +
              std::to_string(dimension));
  refuse_options_of_files(options);
  return make(options, [&](JobOptions& job, const std::stop_token&) {
    return Cloud::open_source(array_source("the array", coordinates, dimension), job.cloud);
  });
}

Triangulation triangulate(const Records& records, const TriangulationOptions& options) {
  const int dimension = OptionsInside::of(options).job.cloud.dimension;
  require(dimension == 2 || dimension == 3, option("dim") + ": must be 2 or 3 for an array");
  refuse_options_of_files(options);
  return make(options, [&](JobOptions& job, const std::stop_token&) {
    return Cloud::open_source(record_source("the array", records.bytes, records.columns, records.rows), job.cloud);
  });
}

Triangulation triangulate(const std::vector<std::string>& inputs, const TriangulationOptions& options) {
  const auto& asked = OptionsInside::of(options);
  require(!inputs.empty() || !asked.job.cloud.input_list.empty(), "no input file is given");
  require(!asked.resume || std::find(inputs.begin(), inputs.end(), "-") == inputs.end(),
          option("resume") + ": standard input cannot be read again; save it in a file");
  return make(options, [&](JobOptions& job, const std::stop_token& stop) {
    const UseObjects use(far_objects(asked.s3));
    return open_cloud(inputs, job, stop);
  });
}

std::string describe(const std::vector<std::string>& inputs, const TriangulationOptions& options) {
  return guarded([&] {
    require(!inputs.empty() || !OptionsInside::of(options).job.cloud.input_list.empty(), "no input file is given");
    const UseObjects use(far_objects(OptionsInside::of(options).s3));
    auto described = tessera::describe(inputs, job_options(options), {.json = true}, OptionsInside::of(options).stop);
    if (described.error) throw_failure(*described.error);
    return std::move(described.text);
  });
}

}  // namespace tessera
