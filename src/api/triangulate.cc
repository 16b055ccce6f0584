#include <chrono>
#include <future>
#include <string>
#include <utility>

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

// The job works in a thread of its own, so that this one can tell how far it is. Whatever goes wrong, the job has ended
// and the folder is clean before it is told.
void run_watched(const TriangulationOptions& options, const OpenCloud& open, ResultFolder& folder) {
  constexpr std::chrono::milliseconds interval(100);
  const JobOptions job = job_options(options);
  Engine engine(job.threads, job.memory_bytes);
  Progress progress;
  std::stop_source stop;
  const std::stop_callback forward(options.stop, [&] { stop.request_stop(); });
  auto outcome = guarded([&] {
    return std::async(std::launch::async,
                      [&] { return run_job(engine, job, open, folder, progress, stop.get_token()); });
  });
  try {
    while (options.progress && outcome.wait_for(interval) != std::future_status::ready)
      options.progress(look(progress));
    const auto summary = guarded([&] { return outcome.get(); });
    if (!summary) {
      const bool asked = summary.error().code == Errc::interrupted;
      throw_failure(asked ? error(Errc::interrupted, "stopped, as was requested") : summary.error());
    }
  } catch (...) {
    stop.request_stop();
    if (outcome.valid()) outcome.wait();
    folder.abandon();
    throw;
  }
  if (options.progress) options.progress(look(progress));
}

}  // namespace

// Has access to the inside of a Triangulation.
struct TriangulationMaker {
  static Triangulation make(const TriangulationOptions& options, const OpenCloud& open) {
    std::optional<TemporaryFolder> temporary;
    if (options.folder.empty()) temporary.emplace(value_or_throw(TemporaryFolder::make()));
    const auto path = temporary ? temporary->path() : options.folder;
    {
      auto folder = value_or_throw(ResultFolder::inspect(path, false, options.overwrite));
      run_watched(options, open, folder);
    }
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
