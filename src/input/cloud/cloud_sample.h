// A few points that stand for a whole cloud.
#pragma once

#include <cstddef>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud.h"

namespace tessera {

// Returns about `wanted` points, spread over all files, after the filters. The sample is deterministic. Takes blocks
// that are spread evenly over files that can seek cheaply, and every k-th point of other files, which it reads to their
// ends.
Result<std::vector<Point>> sample_cloud(const Cloud& cloud, std::size_t wanted);

}  // namespace tessera
