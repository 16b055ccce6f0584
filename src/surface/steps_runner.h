// Runs the steps of a surface. An engine does that, in one process or on a cluster (src/job/engine_steps.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "src/base/result.h"

namespace tessera::surface {

class StepsRunner {
 public:
  virtual ~StepsRunner() = default;
  // Runs the steps to the end of the last one; steps that the run folder has finished are not run again. The plan is in
  // the run folder. `lock_file`: the lock that must be held to write there (check_held()). `part`: called with the
  // fraction that is done, from 0 to 1; or null.
  virtual Status run(const std::filesystem::path& result, const std::filesystem::path& run,
                     const std::filesystem::path& lock_file, const std::function<void(double)>& part,
                     const std::stop_token& stop) = 0;
  // Returns the memory for work that one tile does better than all tiles, because few threads work on them; 0: all
  // tiles do it.
  virtual std::uint64_t bytes_of_one() const = 0;
};

}  // namespace tessera::surface
