// Proves that a surface file is closed; and, if its triangulation is given, that it is the surface of a minimum cut.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/surface/recipe.h"
#include "src/surface/steps_runner.h"
#include "src/surface/surface.h"

namespace tessera {

struct VerifySurfaceOptions {
  std::optional<std::filesystem::path> triangulation = {};  // the result from which the surface was made
  std::uint64_t memory_bytes = 0;
  unsigned threads = 1;
  std::filesystem::path scratch;  // a folder
  // Turns SensorOptions::text, which says what was asked for, into sensors.
  std::function<Result<SensorOptions>(const std::string&)> sensors;
};

struct SurfaceReport {
  std::uint64_t triangles = 0, vertices = 0;
  std::uint64_t ends = 0;           // edges where the surface ends, as its options allow
  std::vector<std::string> passed;  // one line for each check
  std::string note = {};            // what was not checked
};
std::string to_json(const SurfaceReport& report, const std::string& mesh);

// Whether verify_surface() is for this file or folder: a .ply, or a folder with some and without a result.
Result<bool> is_surface(const std::filesystem::path& path);

// Verifies a surface. `mesh`: a file, or a folder with a file for each tile. Checks that each edge has as many
// triangles in one direction as in the other, except where the options let the surface end, and that no triangle occurs
// twice. With the triangulation, the surface is made again, each cut is proved by its flow, and triangles and positions
// of vertices are compared. Error not_delaunay tells the first violation; bad_input a damaged file.
Result<SurfaceReport> verify_surface(const std::filesystem::path& mesh, const VerifySurfaceOptions& options,
                                     surface::StepsRunner& runner, const std::stop_token& stop);

}  // namespace tessera
