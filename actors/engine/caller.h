// Waits for the end of a job over a cloud, and passes on what is told of it, for Engine::run().
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <vector>

#include "actors/run_owner.h"
#include "src/base/progress.h"
#include "src/delaunay/run/run_summary.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Its methods are called from the coordinator's thread, except wait() and summary().
class RunCaller final : public RunOwner {
 public:
  explicit RunCaller(Progress& progress) : progress_(progress) {}

  void progressed(const RunProgress& now) override;
  void stored(const TileDone& done) override;
  void said(const std::string& line) override { progress_.log(line); }
  void ended(RunEnded end) noexcept override;

  // Blocks until the run has ended. Called once.
  RunEnded wait() { return end_->get_future().get(); }
  // Returns the summary of a run that has ended without a failure.
  RunSummary summary(const RunEnded& ended);

 private:
  Progress& progress_;
  const double opened_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - progress_.started).count();
  struct Stored {
    TileEntry entry;
    std::uint64_t microseconds = 0;
  };
  std::vector<Stored> done_;
  std::shared_ptr<std::promise<RunEnded>> end_ = std::make_shared<std::promise<RunEnded>>();
};

}  // namespace tessera
