// Runs jobs over the tiles of a result. An engine does that, in one process or on a cluster (src/job/engine_steps.h).
#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "src/base/result.h"

namespace tessera {

class StagesRunner {
 public:
  virtual ~StagesRunner() = default;
  // Runs a job of this kind (KindsOfStages) to the end of its last stage; stages that the run folder has finished are
  // not run again. The plan is in the run folder. `lock_file`: the lock that must be held to write there
  // (check_held()); empty: there is none. `part`: called with the fraction that is done, from 0 to 1; or null.
  virtual Status run(const std::string& kind, const std::filesystem::path& result, const std::filesystem::path& run,
                     const std::filesystem::path& lock_file, const std::function<void(double)>& part,
                     const std::stop_token& stop) = 0;
};

}  // namespace tessera
