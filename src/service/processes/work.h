// Does the work of a job, from its record to its results. Does not know the queue, states and locks.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "actors/engine/engine.h"
#include "job_record.pb.h"
#include "src/base/files/folder_lock.h"
#include "src/base/ledger.h"
#include "src/base/progress.h"
#include "src/service/processes/convert.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/region_clouds.h"
#include "src/service/results/result_folders.h"
#include "src/service/inputs/roots.h"
#include "src/service/service.h"

namespace tessera {

// What all jobs of a service share.
struct Workshop {
  Engine& engine;
  const Roots& roots;
  Results& results;
  std::filesystem::path data;
  ServiceLimits limits;
  JobShare share;
  RegionClouds& clouds;
  std::chrono::milliseconds data_lease{60'000};
};

struct JobWork {
  const proto::JobRecord& job;
  Progress& progress;
  Ledger& ledger;
  std::function<void(const std::string&)> log;
  std::filesystem::path scratch;
};

struct JobDone {
  std::string outcome;  // JSON
  std::uint64_t points = 0;
  std::vector<std::pair<std::string, double>> seconds;  // by phase
};

// Does a job. When this returns without a problem, a triangulation is complete in Results::unfinished(job), and an
// export in Results::unfinished_export(), and nothing was written elsewhere. After a problem with the cause
// interrupted, the same job can continue later from where it was. After other problems, files of no further use are
// removed. A job of any kind draws from `work.ledger`; when it meets a bound, its problem names the bound.
Reply<JobDone> do_work(const Workshop& shop, const JobWork& work);

// How the folder of a job's output is locked. A daemon that held the data folder before, and worked on the job, may
// still have this lock. Such a daemon is silent, so its lock is waited for.
LockOptions lock_of_unfinished(const Workshop& shop, const std::stop_token& stop);

// The problem of a comparison with CGAL, which is made in memory, when it needs more memory than there is.
std::optional<proto::Problem> check_verify(const Workshop& shop, const proto::VerifyInputs& inputs);

// Returns what `tessera info --json` prints.
Result<std::string> describe_inputs(const Workshop& shop, const proto::InfoInputs& inputs, const std::stop_token& stop);
// Returns a problem for inputs that take too long for a request: compressed files, and statistics of more than
// `points_max` points.
Result<std::optional<proto::Problem>> takes_too_long(const Workshop& shop, const proto::InfoInputs& inputs,
                                                     std::uint64_t points_max);

}  // namespace tessera
