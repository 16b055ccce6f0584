// The files that hold a grid as an array: .npy, .h5 and .fits. Each is written in runs of values, so that the grid may
// be larger than memory, and appears whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/result/density/gridding.h"

namespace tessera::density {

// What files say of the values.
struct GridLabels {
  std::string about;               // "density of mass", "curl of vx,vy,vz"
  std::vector<std::string> names;  // of the components: "density", "curl_x", a field's own name
  std::string unit;                // "" if it is not known
};
GridLabels labels_of(const GridRequest& request, const GridOptions& options);

// Each writes `target` and returns its size in bytes. `gridding` has run. Errors: those of Gridding::for_each_run() and
// of writing.

// An array with the indices [y][x] or [z][y][x], and one more for the components if there are several.
Result<std::uint64_t> write_npy(const std::filesystem::path& target, const GridRequest& request,
                                const GridOptions& options, Gridding& gridding);
// A table for each component, with the indices [y][x] or [z][y][x] and the attributes `unit` and `description`. The
// file has the attributes origin, res, size and period, which are lists along x, y and z, and made_by, version and
// digest, which say of what it was made.
Result<std::uint64_t> write_hdf5(const std::filesystem::path& target, const GridRequest& request,
                                 const GridOptions& options, Gridding& gridding);
// An image of 64-bit floats, the first axis of which is x. Of several components each is an extension of its own. Cards
// of a linear coordinate system have the places of pixels; PERIOD1 and so on have the period.
Result<std::uint64_t> write_fits(const std::filesystem::path& target, const GridRequest& request,
                                 const GridOptions& options, Gridding& gridding);

}  // namespace tessera::density
