// Computes the triangles of the surface of a 3D result, and stores them as a 2D result with heights.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/result/store/digest.h"
#include "src/result/tile_source.h"
#include "src/surface/kept_codec.h"
#include "src/surface/steps_runner.h"
#include "src/surface/surface.h"

namespace tessera::surface {

// What build() has made.
struct Built {
  std::filesystem::path triangles;  // the folder of the 2D result
  Digest digest;
  std::uint64_t split = 0;  // vertices that were added to make it manifold
  std::string sensors;      // how sensors were found: a sentence
  double sigma = 0;         // the median scale of the vertices, or what was given
  RayCounts rays;
  std::uint64_t undecided = 0, outside = 0;  // cells
};

struct BuildFolder {
  std::filesystem::path run;        // the run folder; the triangles are in it, too
  std::filesystem::path lock_file;  // the lock that must be held to write there; empty: no other process writes there
  bool resume = false;              // continues what an earlier process has left there
};

// Builds the surface. `prove`: each cut is proved by its flow (src/surface/cut/certificate.h); error internal when a
// proof fails. `progress`: called with the fraction that is done; or null. Errors: usage for results that have no
// surface, and when the run to be resumed is of another result or has other options; errors of reading and running.
Result<Built> build(const TileSource& source, const SurfaceOptions& options, const BuildFolder& folder, bool prove,
                    StepsRunner& runner, const std::function<void(double)>& progress, const std::stop_token& stop);

}  // namespace tessera::surface
