// The steps of a surface as a job over the tiles of a result: its plan, and its programs on a node.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "src/delaunay/run/result_stages.h"
#include "src/surface/sensors.h"
#include "src/surface/steps.h"

namespace tessera::surface {

// What a tile takes while it is worked on, beside reading it: stars and weights, its graph, a copy of that, trees.
inline constexpr std::uint64_t bytes_a_cell = 170;

inline constexpr const char* kind_of_surface = "surface";  // ShareSpec::stages

// The job. The steps depend on it and on the result alone.
struct SurfacePlan {
  StepOptions options;
  SensorOptions sensors;     // with nothing left to estimate
  std::string result;        // the digest of the triangulation
  std::string tiles;         // checksum of its tile list: results with equal digests may differ in it
  std::uint64_t number = 0;  // random number of the run, so that plans of two runs always differ
};
std::string to_json(const SurfacePlan& plan);
// `name`: of the file, for errors. Error corrupt.
Result<SurfacePlan> read_plan(std::span<const std::byte> bytes, const std::string& name);

class SurfaceStages final : public ResultStages {
 public:
  std::uint32_t count() const override { return steps_count; }
  Result<std::vector<std::shared_ptr<const TilePrograms>>> programs(const ResultInput& input) const override;
  Result<std::vector<TileReceipt>> stored(const std::filesystem::path& run, std::uint32_t stage) const override;
  std::uint64_t work_bytes(const TileSource& source, std::size_t i) const override;
};

}  // namespace tessera::surface
