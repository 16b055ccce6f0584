// Waits for the end of a job over a result, and tells how much of it is done.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include "actors/run_owner.h"
#include "src/base/progress.h"

namespace tessera {

class StagesCaller final : public RunOwner {
 public:
  // The job has `stages` stages and begins with the stage `first`. `fraction` is told how much is done, from 0 to 1; it
  // may be null.
  StagesCaller(std::uint32_t first, std::uint32_t stages, std::size_t tiles, std::function<void(double)> fraction,
               Progress& progress)
      : first_(first), stages_(stages), tiles_(tiles), fraction_(std::move(fraction)), progress_(progress) {}

  // In each stage one half is for the beginning of its tiles, the other half for their end.
  void progressed(const RunProgress& now) override {
    progress_.memory_bytes = now.sum.memory_bytes;
    progress_.nodes_lost = now.nodes_lost;
    if (!fraction_) return;
    const auto share = [&](std::uint64_t tiles) {
      return std::min(1.0, static_cast<double>(tiles) / static_cast<double>(std::max<std::size_t>(tiles_, 1)));
    };
    const double in_stage = (share(now.sum.tiles_begun) + share(now.sum.tiles_stored)) / 2;
    const double done = (first_ + now.stage + in_stage) / stages_;
    if (done > done_) fraction_(done_ = std::min(1.0, done));
  }
  void stored(const TileDone&) override {}
  void said(const std::string& line) override { progress_.log(line); }
  void ended(RunEnded end) noexcept override {
    const auto told = end_;  // the waiting thread may destroy this object before this returns
    told->set_value(std::move(end));
  }
  RunEnded wait() { return end_->get_future().get(); }

 private:
  std::uint32_t first_, stages_;
  std::size_t tiles_;
  std::function<void(double)> fraction_;
  Progress& progress_;
  double done_ = 0;
  std::shared_ptr<std::promise<RunEnded>> end_ = std::make_shared<std::promise<RunEnded>>();
};

}  // namespace tessera
