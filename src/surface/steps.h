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

// The same in all processes.
struct StepOptions {
  Energy energy;
  CutRule rule;
  Boundary boundary;
  bool splits = false;  // finds what is to be split where the surface is not manifold
  bool prove = false;   // each cut by its flow
  // All cells are decided at once, by one tile, for which there is memory: no tile decides anything alone before. For
  // machines of few threads, as that is less work.
  bool together = false;
};

struct StepInput {
  StepOptions options;
  Sensors sensors;
  Solidity solidity;
  std::vector<TileId> tiles;  // those that have points, ascending: the first one does what one alone must do
  std::uint64_t cells = 0;    // of the whole
  std::stop_token stop = {};  // once requested, long work soon throws Stopped
};

std::shared_ptr<const TilePrograms> programs_of(Step step, std::shared_ptr<const StepInput> input,
                                                std::shared_ptr<StepStore> store);

// What the step scales has found, or what was given.
Result<double> sigma_of(const StepInput& input, StepStore& store);

}  // namespace tessera::surface
