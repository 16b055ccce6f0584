// The whole engine in this process, as `tessera triangulate` runs it: read, route, triangulate, exchange, store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "actors/engine/engine.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/routed_cloud.h"

namespace tessera::testing {

// One byte of memory makes every tile sleep when it may.
struct EngineOptions : RunOptions {
  int dimension = 3;
  PartitionKind partition = PartitionKind::kdtree;
  std::uint32_t tiles = 1;
  bool skip_invalid = false;
  std::vector<double> periodic = {};  // as CloudOptions::periodic
};

// "3D kdtree tiles 7 threads 2 reduced memory 1": enough to repeat it.
std::string text_of(const EngineOptions& options);

struct EngineRun {
  RoutedCloud routed;
  RunSummary summary;
  Manifest manifest;
};

// Leaves the result in `out`, which must not exist, and no run folder.
Result<EngineRun> run_engine(const std::filesystem::path& input, const std::filesystem::path& out,
                             const EngineOptions& options);

}  // namespace tessera::testing
