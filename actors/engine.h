// One process's node and the jobs it runs. Jobs that run at once take turns on the engine's threads, each on at most as
// many as it asks for; memory is each one's own while it runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>

#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/run/part.h"
#include "src/run/run_summary.h"
#include "src/tiling/routed_run.h"

namespace tessera {

class Engine {
 public:
  // For all jobs together: threads that work on tiles, and memory.
  Engine(std::uint32_t threads, std::uint64_t memory_bytes);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // Runs the tiles of a routed cloud as actors until message counting proves quiet, and stores them. Returns when
  // nothing works on them any more, and its memory is free for another run. Error interrupted when `stop` was
  // requested: what is on scratch stays for a run that goes on; memory, at once, when the others have left too little.
  // Several threads may call this at once, for different runs.
  Result<RunSummary> run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                         Progress& progress, std::stop_token stop);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
