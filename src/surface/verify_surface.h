// Proves files of a surface: closed, and if its triangulation is at hand, the surface of a minimum cut of its cells.
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
  std::optional<std::filesystem::path> triangulation = {};  // the result that the surface was made of
  std::uint64_t memory_bytes = 0;
  unsigned threads = 1;
  std::filesystem::path scratch;  // a folder
  // From what was asked for to the sensors: SensorOptions::text.
  std::function<Result<SensorOptions>(const std::string&)> sensors;
};

struct SurfaceReport {
  std::uint64_t triangles = 0, vertices = 0;
  std::uint64_t ends = 0;           // edges where the surface ends, as its options let it
  std::vector<std::string> passed;  // one line a check
  std::string note = {};            // what stays open
};
std::string to_json(const SurfaceReport& report, const std::string& mesh);

// Whether this is a file or folder that verify_surface() is for: a .ply, or a folder with some and no result.
Result<bool> is_surface(const std::filesystem::path& path);

// `mesh`: a file, or a folder with one a tile. Each edge has as many triangles one way as the other, but where the
// options said that it ends; no triangle is there twice. With the triangulation: the surface is made once more, each
// cut is proved by its flow, and triangles and places of vertices are compared.
// Error not_delaunay tells the first violation; bad_input a damaged file.
Result<SurfaceReport> verify_surface(const std::filesystem::path& mesh, const VerifySurfaceOptions& options,
                                     surface::StepsRunner& runner, const std::stop_token& stop);

}  // namespace tessera
