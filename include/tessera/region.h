// A region of raw clouds, without triangulating the rest of the clouds (docs/regions.md).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/options.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

// Limits on what triangulate_region() reads. Every function returns *this.
class TESSERA_PUBLIC RegionRequest {
 public:
  RegionRequest();
  RegionRequest(const RegionRequest&);
  RegionRequest& operator=(const RegionRequest&);
  ~RegionRequest();

  // Reads all files once to learn where their points are, instead of relying on the boxes that the files state.
  RegionRequest& scan_files(bool scan);
  // Triangulates at most so many points; by default as many as fit in memory.
  RegionRequest& max_points(std::uint64_t points);
  // Gives up after about so many seconds, above 0; by default never.
  RegionRequest& max_seconds(double seconds);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Returns exactly those cells of the triangulation of all points of `inputs` that have a point in common with the
// closed box. The box is xmin, ymin, xmax, ymax in 2D, and xmin, ymin, zmin, xmax, ymax, zmax in 3D. Source indices are
// those of the whole triangulation. The result has one tile; verify() and Questions refuse it. The options about tiles
// (max_points_per_tile(), tiles(), partition(), store()) and progress() have no effect; resume() is refused.
// Failure: usage when no cell meets the box; memory when the limits of `request` or of the memory are too low;
// bad_input also when a file has points outside the box that it states; io, corrupt, interrupted.
TESSERA_PUBLIC Triangulation triangulate_region(const std::vector<std::string>& inputs, std::span<const double> box,
                                                const TriangulationOptions& options = {},
                                                const RegionRequest& request = {});

}  // namespace tessera
