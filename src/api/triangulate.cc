#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "src/api/entry.h"
#include "src/api/errors.h"
#include "src/api/triangulation_impl.h"
#include "src/base/option.h"
#include "src/io/npy/array_source.h"
#include "src/job/inputs.h"
#include "src/job/job.h"
#include "src/job/machine.h"
#include "tessera/triangulation.h"

namespace tessera {
namespace {

void require(bool holds, const std::string& otherwise) {
  if (!holds) throw Failure(Cause::usage, otherwise);
}

JobOptions job_options(const TriangulationOptions& options) {
  require(options.threads <= threads_max,
          option("threads") + ": " + std::to_string(options.threads) + " are more than " + std::to_string(threads_max));
  JobOptions job;
  job.threads = options.threads > 0 ? options.threads : usable_processors();
  job.memory_bytes = options.memory_bytes > 0 ? options.memory_bytes : default_memory();
  job.max_points_per_tile = options.max_points_per_tile;
  job.neighbors = options.neighbors;
  job.cloud.dimension = options.dimension;
  job.cloud.skip_invalid = options.skip_invalid;
  job.cloud.recursive = options.recursive;
  job.cloud.attributes = options.attributes;
  job.cloud.threads = job.threads;
  job.resumable = false;
  job.command = {"tessera::triangulate"};
  return job;
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

// A job, which works in a thread of its own so that the one that called can tell how far it is.
class WatchedJob {
 public:
  // Looks at nothing of `options` but in this thread.
  WatchedJob(const TriangulationOptions& options, const OpenCloud& open, ResultFolder folder)
      : folder_(std::move(folder)),
        job_(job_options(options)),
        engine_(job_.threads, job_.memory_bytes),
        forward_(options.stop, [this] { stop_.request_stop(); }),
        outcome_(std::async(std::launch::async, [this, &open] {
          return run_job(engine_, job_, open, folder_, progress_, stop_.get_token());
        })) {}

  // Until it is done, tells `progress`, which may throw.
  void watch(const std::function<void(const JobProgress&)>& progress) {
    constexpr std::chrono::milliseconds interval(100);
    while (outcome_.wait_for(interval) != std::future_status::ready) {
      call_back(progress, look(progress_));
    }
  }
  // Waits for its end.
  void finish() {
    const auto summary = outcome_.get();
    if (summary) return;
    const bool asked = summary.error().code == Errc::interrupted;
    throw_failure(asked ? error(Errc::interrupted, "stopped, as was requested") : summary.error());
  }
  // Whatever went wrong: ends it and cleans the folder.
  void abandon() {
    stop_.request_stop();
    if (outcome_.valid()) outcome_.wait();
    folder_.abandon();
  }
  JobProgress progress() const { return look(progress_); }

 private:
  ResultFolder folder_;
  JobOptions job_;
  Engine engine_;
  Progress progress_;
  std::stop_source stop_;
  std::stop_callback<std::function<void()>> forward_;
  std::future<Result<std::optional<JobSummary>>> outcome_;
};

// Whatever goes wrong, the job has ended and the folder is clean before it is told.
void run_watched(const TriangulationOptions& options, const OpenCloud& open, ResultFolder folder) {
  auto job = guarded([&] { return std::make_unique<WatchedJob>(options, open, std::move(folder)); });
  try {
    if (options.progress) job->watch(options.progress);
    guarded([&] { job->finish(); });
  } catch (...) {
    // In a child that was forked by the callback the job's threads are not there, and its folder is the parent's.
    is_forked_within() ? static_cast<void>(job.release()) : job->abandon();
    throw;
  }
  call_back(options.progress, job->progress());
}

}  // namespace

// Has access to the inside of a Triangulation.
struct TriangulationMaker {
  static Triangulation make(const TriangulationOptions& options, const OpenCloud& open) {
    const Entry entry;
    std::optional<TemporaryFolder> temporary;
    if (options.folder.empty()) temporary.emplace(value_or_throw(TemporaryFolder::make()));
    const auto path = temporary ? temporary->path() : options.folder;
    run_watched(options, open, value_or_throw(ResultFolder::inspect(path, false, options.overwrite)));
    auto manifest = value_or_throw(read_manifest(path));
    return Triangulation(std::make_shared<const Triangulation::Impl>(
        Triangulation::Impl{path, std::move(manifest), std::move(temporary)}));
  }
};

Triangulation triangulate(std::span<const double> coordinates, const TriangulationOptions& options) {
  const int dimension = options.dimension;
  require(dimension == 2 || dimension == 3, option("dim") + ": of an array it must be 2 or 3");
  require(coordinates.size() % static_cast<std::size_t>(dimension) == 0,
          "the array: its length, " + std::to_string(coordinates.size()) + ", is no multiple of the dimension, " +
              std::to_string(dimension));
  return TriangulationMaker::make(options, [&](JobOptions& job, const std::stop_token&) {
    return Cloud::open_source(array_source("the array", coordinates, dimension), job.cloud);
  });
}

Triangulation triangulate(const std::vector<std::string>& inputs, const TriangulationOptions& options) {
  require(options.dimension == 0 || options.dimension == 2 || options.dimension == 3,
          option("dim") + ": must be 0, 2 or 3");
  require(!inputs.empty(), "no input file is given");
  return TriangulationMaker::make(
      options, [&](JobOptions& job, const std::stop_token& stop) { return open_cloud(inputs, job, stop); });
}

}  // namespace tessera
