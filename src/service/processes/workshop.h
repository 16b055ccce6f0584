// What all jobs of a service share.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "actors/engine/engine.h"
#include "service.pb.h"
#include "src/base/files/folder_lock.h"
#include "src/service/inputs/roots.h"
#include "src/service/limits.h"
#include "src/service/processes/convert.h"
#include "src/service/processes/region_clouds.h"
#include "src/service/results/result_folders.h"

namespace tessera::service {

struct Workshop {
  Engine& engine;
  const Roots& roots;
  ResultFolders& results;
  std::filesystem::path data;
  ServiceLimits limits;
  JobShare share;
  RegionClouds& clouds;
  std::chrono::milliseconds data_lease{60'000};
};

// How the folder of a job's output is locked. A daemon that held the data folder before, and worked on the job, may
// still have this lock. Such a daemon is silent, so its lock is waited for.
LockOptions lock_of_unfinished(const Workshop& shop, const std::stop_token& stop);

// The problem of inputs that mean no files. Nothing when there are too many to look at while a caller waits.
std::optional<proto::Problem> check_files(const Workshop& shop,
                                          const google::protobuf::RepeatedPtrField<std::string>& names, bool recursive);

// Names inputs in the problem as callers name them, not by their paths on this machine.
proto::Problem in_callers_words(const Workshop& shop, proto::Problem problem);

}  // namespace tessera::service
