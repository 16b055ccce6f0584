// A region of raw clouds, without triangulating the rest (docs/regions.md).
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

// How much may be read for a region.
class TESSERA_PUBLIC RegionRequest {
 public:
  RegionRequest();
  RegionRequest(const RegionRequest&);
  RegionRequest& operator=(const RegionRequest&);
  ~RegionRequest();

  // Read all files once and see where their points are, instead of believing the boxes that they state.
  RegionRequest& scan(bool scan);
  // Triangulate at most so many points; by default what the memory allows.
  RegionRequest& max_points(std::uint64_t points);
  // Give up after about so many seconds; by default never.
  RegionRequest& max_seconds(double seconds);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Exactly the cells of the triangulation of all points of `inputs` that have a point in common with the closed box, in
// 2D xmin, ymin, xmax, ymax, in 3D xmin, ymin, zmin, xmax, ymax, zmax; with the ranks of the whole job. It is a result
// of one tile. Of `options` those that say how cells are cut into tiles do not count, nor progress; resume is refused.
// Failure: usage when no cell meets the box; memory when more would have to be read than may; bad_input when a file
// does not keep to the box it states; io, corrupt, interrupted.
TESSERA_PUBLIC Triangulation triangulate_region(const std::vector<std::string>& inputs, std::span<const double> box,
                                                const TriangulationOptions& options = {},
                                                const RegionRequest& request = {});

}  // namespace tessera
