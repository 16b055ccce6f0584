// The code that has a job run, as the job's coordinator sees it. It is in the same process and is called and not sent
// messages, because it may be a thread that does nothing but wait.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "actors/protocol.h"
#include "src/base/progress.h"

namespace tessera {

// What the tiles of a stage do: begin, exchange messages, come to their end.
enum class RunStep : std::uint8_t { beginning, exchanging, ending };
struct RunProgress {
  std::uint32_t stage = 0;  // number of stages that have ended under this coordinator
  RunStep step = RunStep::beginning;
  ShareProgress sum;
  std::vector<NodeProgress> nodes;  // that have or had a share, in the order of coming
  std::uint32_t nodes_lost = 0;
};

// Wall-clock times of the steps of a stage.
struct StageTimes {
  std::uint64_t begin_us = 0, exchange_us = 0, end_us = 0;
};

struct RunEnded {
  Failure failure;
  bool again = false;  // damaged scratch was found too late to tell tiles anything more; the next run repairs it
  std::uint64_t waves = 0;
  std::uint64_t nodes = 0, nodes_lost = 0, tiles_again = 0;  // tiles_again: tiles that began again after losses
  std::uint64_t memory_bytes = 0;                            // that all nodes gave the job, together
  ShareEnded sum;
  std::vector<StageTimes> stages;  // those that this coordinator has seen
};

// Called from the coordinator's thread. An exception ends the job.
class RunOwner {
 public:
  virtual ~RunOwner() = default;
  virtual void progressed(const RunProgress& now) = 0;
  virtual void stored(const TileDone& tile) = 0;
  virtual void said(const std::string& line) = 0;  // for the job's log
  // Called exactly once, at the end. The coordinator does not use its owner after that.
  virtual void ended(RunEnded end) noexcept = 0;
};

}  // namespace tessera
