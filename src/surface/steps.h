// What tiles do in the steps of a surface (step.h), as stages of the exchange.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "src/exchange/tile_program.h"
#include "src/surface/sensors.h"
#include "src/surface/step.h"
#include "src/surface/step_store.h"
#include "src/surface/triangles.h"

namespace tessera::surface {

// Equal in all processes of a job.
struct StepOptions {
  Energy energy;
  CutRule rule;
  Boundary boundary;
  bool splits = false;  // whether to find what must be split where the surface is not manifold
  bool prove = false;   // whether each cut is proved by its flow
  // One tile, for which there is memory, decides all cells at once, and no tile decides anything alone before. That is
  // less work, so it serves machines with few threads.
  bool together = false;
};

struct StepInput {
  StepOptions options;
  Sensors sensors;
  Solidity solidity;
  std::vector<TileId> tiles;  // tiles that have points, ascending; the first does what only one tile can do
  std::uint64_t cells = 0;    // of the whole triangulation
  std::stop_token stop = {};  // once requested, long work soon throws Stopped
};

std::shared_ptr<const TilePrograms> programs_of(SurfaceStageId step, std::shared_ptr<const StepInput> input,
                                                std::shared_ptr<StepStore> store);

// Returns the scale that the step scales has found, or that was given.
Result<double> sigma_of(const StepInput& input, StepStore& store);

}  // namespace tessera::surface
