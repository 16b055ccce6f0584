// Runs jobs over results on an engine.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "actors/engine/engine.h"
#include "src/delaunay/run/stages_runner.h"
#include "src/surface/steps_runner.h"

namespace tessera {

// Returns all kinds of such jobs. Every engine that runs these jobs, or is a node of them, is given this map.
KindsOfStages kinds_of_stages();

// Runs the steps of a surface on an engine, in one process or on a cluster.
class EngineSteps final : public surface::StepsRunner {
 public:
  // `engine` and `progress` outlive this object. `options`: without a lock file.
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

// Runs jobs of any kind on an engine.
class EngineStages final : public StagesRunner {
 public:
  // As EngineSteps.
  EngineStages(Engine& engine, ShareOptions options, Progress& progress)
      : engine_(engine), options_(std::move(options)), progress_(progress) {}
  Status run(const std::string& kind, const std::filesystem::path& result, const std::filesystem::path& run,
             const std::filesystem::path& lock_file, const std::function<void(double)>& part,
             const std::stop_token& stop) override;

 private:
  Engine& engine_;
  ShareOptions options_;
  Progress& progress_;
};

}  // namespace tessera
