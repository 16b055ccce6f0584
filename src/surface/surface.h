// A closed surface of a 3D result: the boundary between the cells that are outside and those that are inside, which a
// minimum cut of their graph tells apart (docs/surfaces.md).
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
    open,    // the same without those facets: the surface ends at the hull
    free     // below is outside, as it is above: things that hang in the air
  };
  Bottom bottom = Bottom::closed;
  bool unknown_inside = true;       // where no ray says anything
  std::optional<double> trim = {};  // leaves out triangles with a longer edge, so that the surface is not closed
  bool manifold = false;            // splits vertices and edges where the surface touches itself; nothing moves
  unsigned smooth = 0;              // rounds of smoothing, which move the vertices, smooth_rounds_max at most
  bool resume = false;              // goes on with what an interrupted run has left, and leaves it when interrupted
  LockOptions lock;                 // how the folder is locked that it is made in
  ExportOptions output;             // of the mesh
  std::uint64_t memory_bytes = 0;   // at least what a tile takes is used
  unsigned threads = 1;
  // Told the part that is done, by one thread at a time; or null.
  std::function<void(double)> progress = {};
};

inline constexpr unsigned smooth_rounds_max = 1000;

// Error usage when a number makes no sense.
Status check_surface_options(const SurfaceOptions& options);
// Where it would be written. Error usage when it cannot be, io.
Result<std::filesystem::path> find_surface_target(const std::filesystem::path& target, const ExportOptions& options);

struct Surface {
  Exported mesh;
  Digest digest;                  // of its triangles and vertices: a function of the points, sensors and options alone
  std::string sensors;            // a sentence on what was used
  double sigma = 0;               // the median scale of the vertices, in units of the coordinates
  std::uint64_t rays = 0;         // vertices with a sensor
  std::uint64_t no_rays = 0;      // without one
  std::uint64_t guessed = 0;      // of the rays, those whose sensor is taken to be straight above
  std::uint64_t handed_over = 0;  // rays from tile to tile
  std::uint64_t steps = 0;        // of rays, through a cell each
  std::uint64_t split = 0;        // vertices that were added to make it manifold
  std::uint64_t cells = 0;        // of the result
  std::uint64_t undecided = 0;    // cells that no tile has decided alone
  std::uint64_t outside = 0;      // cells
};
std::string to_json(const Surface& surface, const std::string& output);

// The surface of the result `in`, to a file or a folder, by its ending, as export_result() does it; in the format
// tileset_format to a folder as write_tileset() does it, and manifold then, so that levels fit together. Errors: usage
// for options that make no sense and for results that are not whole or not in 3D; those of reading and of
// export_result(). What waits meanwhile stands in a folder beside it, of the target's name and ".surface".
Result<Surface> make_surface(const std::filesystem::path& in, const std::filesystem::path& target,
                             const SurfaceOptions& options, surface::StepsRunner& runner, std::stop_token stop);

}  // namespace tessera
