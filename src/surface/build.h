// From a 3D result to the triangles of its surface, which whoever wants them reads as a 2D result with heights.
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

struct Built {
  std::filesystem::path triangles;  // the folder
  Digest digest;
  std::uint64_t split = 0;  // vertices that were added to make it manifold
  std::string sensors;      // a sentence
  double sigma = 0;         // the median scale of the vertices, or what was given
  RayCounts rays;
  std::uint64_t undecided = 0, outside = 0;  // cells
};

struct BuildFolder {
  std::filesystem::path run;        // in which the triangles are, too
  std::filesystem::path lock_file;  // of who may write there: none, nobody else would
  bool resume = false;              // goes on with what an earlier process has left there
};

// `prove`: each cut is proved by its flow (src/surface/cut/certificate.h); error internal when one is not. Errors:
// usage for results that have no surface, and when what is to be gone on with is of another one; those of reading and
// running. `progress`: or null.
Result<Built> build(const TileSource& source, const SurfaceOptions& options, const BuildFolder& folder, bool prove,
                    StepsRunner& runner, const std::function<void(double)>& progress, const std::stop_token& stop);

}  // namespace tessera::surface
