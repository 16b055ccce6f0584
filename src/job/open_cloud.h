// From options to a cloud and the size of its tiles; jobs and `tessera info` share this code.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/cloud/cloud.h"
#include "src/job/job_options.h"
#include "src/tiling/budget/budget.h"

namespace tessera {

// Opens the inputs, as Cloud::open takes them. Sets the dimension if the options leave it open (2 when no file has z).
Result<Cloud> open_cloud(const std::vector<std::string>& inputs, JobOptions& options, std::stop_token stop = {});

// Returns how many points a tile may have, as asked for or chosen. Error memory when such a tile cannot be worked on
// within the memory, or on any of the `nodes` of a cluster, if there are any.
Result<std::uint64_t> tile_limit(const JobOptions& options, const Cloud& cloud,
                                 std::span<const budget::NodeShare> nodes = {});

}  // namespace tessera
