// Whoever runs the steps of a surface: an engine, of one process or of a cluster (src/job/engine_steps.h).
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
  // To the end of the last step; those that a run folder has behind it are not run again. The plan stands in the run
  // folder. `lock_file`: of who may write there (check_held()). `part`: told how much is done, from 0 to 1; or null.
  virtual Status run(const std::filesystem::path& result, const std::filesystem::path& run,
                     const std::filesystem::path& lock_file, const std::function<void(double)>& part,
                     const std::stop_token& stop) = 0;
  // Memory for what is better done by one tile than by all, as few threads work on them; 0: none.
  virtual std::uint64_t bytes_of_one() const = 0;
};

}  // namespace tessera::surface
