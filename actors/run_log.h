// What a run adds up to. Written by the node as reports come in, read when it is over.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "actors/local_run.h"

namespace tessera {

struct RunLog {
  RunSummary summary;
  // By tile: the last report's figures, summed up at the end.
  struct TileFigures {
    std::uint64_t received = 0, inserted = 0, kept = 0, points_sent = 0, batches = 0;
  };
  std::vector<TileFigures> tiles;
  double triangulated_s = 0;  // when the last tile had been triangulated, since the node's start
};

}  // namespace tessera
