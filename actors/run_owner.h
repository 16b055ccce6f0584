// Whoever has a job run, as its coordinator sees it: in the same process, and told without messages, for whom to wait
// is all that is left to do.
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
  std::uint32_t stage = 0;  // how many have ended since this coordinator took office
  RunStep step = RunStep::beginning;
  ShareProgress sum;
  std::vector<NodeProgress> nodes;  // that have had a part, in order of coming
  std::uint32_t nodes_lost = 0;
};

// Wall clock of a stage, by its steps.
struct StageTimes {
  std::uint64_t begin_us = 0, exchange_us = 0, end_us = 0;
};

struct RunEnded {
  Failure failure;
  bool again = false;  // damaged scratch was found while no tile could be told anything more: the next run mends it
  std::uint64_t waves = 0;
  std::uint64_t nodes = 0, nodes_lost = 0, tiles_again = 0;  // begun again after losses
  std::uint64_t memory_bytes = 0;                            // that they all gave the job
  ShareEnded sum;
  std::vector<StageTimes> stages;  // that the coordinator saw
};

// Called from the coordinator's thread. What is thrown at it ends the job.
class RunOwner {
 public:
  virtual ~RunOwner() = default;
  virtual void progressed(const RunProgress& now) = 0;
  virtual void stored(const TileDone& tile) = 0;
  virtual void said(const std::string& line) = 0;  // for the job's log
  // Always called in the end, once; the coordinator does not know its owner any more then.
  virtual void ended(RunEnded end) noexcept = 0;
};

}  // namespace tessera
