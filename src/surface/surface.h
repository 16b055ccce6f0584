// A closed surface of a 3D result: the boundary between cells that are outside and cells that are inside. A minimum cut
// of the graph of cells separates them (docs/surfaces.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/files/folder_lock.h"
#include "src/base/result.h"
#include "src/result/export/export.h"
#include "src/result/store/digest.h"
#include "src/surface/energy.h"
#include "src/surface/sensors.h"
#include "src/surface/steps_runner.h"

namespace tessera {

struct SurfaceOptions {
  surface::Energy energy;
  SensorOptions sensors;
  enum class Bottom : std::uint8_t {
    closed,  // what is below the points is inside, and the surface has the hull's facets there
    open,    // the same without these facets: the surface ends at the hull
    free     // what is below is outside, as above: for things that hang in the air
  };
  Bottom bottom = Bottom::closed;
  bool unknown_inside = true;       // cells of which no ray says anything
  std::optional<double> trim = {};  // leaves out triangles with a longer edge; then the surface is not closed
  bool manifold = false;            // splits vertices and edges where the surface touches itself; no vertex moves
  unsigned smooth = 0;              // rounds of smoothing, which move the vertices; at most smooth_rounds_max
  bool resume = false;              // continues what an interrupted run has left, and leaves it when interrupted
  LockOptions lock;                 // how the run folder is locked
  ExportOptions output;             // of the mesh
  std::uint64_t memory_bytes = 0;   // if it is less than one tile takes, that much is used
  unsigned threads = 1;
  // Called with the fraction that is done, by one thread at a time; or null.
  std::function<void(double)> progress = {};
};

inline constexpr unsigned smooth_rounds_max = 1000;

// Returns error usage when a number makes no sense.
Status check_surface_options(const SurfaceOptions& options);
// Returns the path that would be written. Error usage when it cannot be written; io.
Result<std::filesystem::path> find_surface_target(const std::filesystem::path& target, const ExportOptions& options);

// What make_surface() has made.
struct Surface {
  Exported mesh;
  Digest digest;                  // of its triangles and vertices; depends on the points, sensors and options alone
  std::string sensors;            // a sentence: how sensors were found
  double sigma = 0;               // the median scale of the vertices, in units of the coordinates
  std::uint64_t rays = 0;         // vertices with a sensor
  std::uint64_t no_rays = 0;      // vertices without a sensor
  std::uint64_t guessed = 0;      // vertices whose sensor is taken to be straight above
  std::uint64_t handed_over = 0;  // rays that went from tile to tile
  std::uint64_t steps = 0;        // cells that rays have passed, counted for each ray
  std::uint64_t split = 0;        // vertices that were added to make it manifold
  std::uint64_t cells = 0;        // cells of the result
  std::uint64_t undecided = 0;    // cells that no tile has decided alone
  std::uint64_t outside = 0;      // cells that are outside
};
std::string to_json(const Surface& surface, const std::string& output);

// Makes the surface of the result `in`, and writes it to a file or a folder, chosen by the target's ending as in
// export_result(). The format tileset_format goes to a folder, as write_tileset() writes it, and the surface is then
// made manifold, so that levels fit together. Errors: usage for options that make no sense, and for results that are
// not whole or not in 3D; errors of reading and of export_result(). Temporary files are in a folder beside the target,
// with the target's name and ".surface".
Result<Surface> make_surface(const std::filesystem::path& in, const std::filesystem::path& target,
                             const SurfaceOptions& options, surface::StepsRunner& runner, std::stop_token stop);

}  // namespace tessera
