// Reads points that are to be added to a result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud.h"
#include "src/result/store/tile_store.h"

namespace tessera {

struct NewPoints {
  std::vector<Point> points;
  std::vector<std::byte> rows;          // in the schema of the result
  std::vector<Manifest::Input> inputs;  // their source indices count from 0
};

// How a cloud must be opened to have the dimension and the attributes of a result.
CloudOptions options_of_new_points(const Manifest& result, unsigned threads);

// How much new points may be.
struct NewPointsLimits {
  std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();  // of memory
  std::uint64_t points = std::numeric_limits<std::uint64_t>::max();
};

// Reads the whole cloud. `name` and `folder`: of the cloud and the result, for errors. Errors: usage when the
// attributes or the coordinate system differ from those of the result; memory beyond the
// limits; those of reading; interrupted.
Result<NewPoints> read_new_points(const Cloud& cloud, const std::string& name, const Manifest& result,
                                  const std::filesystem::path& folder, const std::stop_token& stop,
                                  const NewPointsLimits& limits = {});

}  // namespace tessera
