// Jobs over results, run by an engine.
#pragma once

#include <cstdint>
#include <utility>

#include "actors/engine/engine.h"
#include "src/surface/steps_runner.h"

namespace tessera {

// All kinds that there are: what every engine is given that runs such jobs, or is a node of those that do.
KindsOfStages kinds_of_stages();

class EngineSteps final : public surface::StepsRunner {
 public:
  // `engine` and `progress` outlive it. `options`: without a lock file.
  EngineSteps(Engine& engine, ShareOptions options, Progress& progress)
      : engine_(engine), options_(std::move(options)), progress_(progress) {}
  Status run(const std::filesystem::path& result, const std::filesystem::path& run,
             const std::filesystem::path& lock_file, const std::function<void(double)>& part,
             const std::stop_token& stop) override;
  std::uint64_t bytes_of_one() const override;

 private:
  Engine& engine_;
  ShareOptions options_;
  Progress& progress_;
};

}  // namespace tessera
