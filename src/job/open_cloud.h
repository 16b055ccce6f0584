// From options to a cloud and the size of its tiles: what a job and `tessera info` share.
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

// Opens the inputs, as Cloud::open takes them; settles the dimension when it was left open (2 when no file holds z).
Result<Cloud> open_cloud(const std::vector<std::string>& inputs, JobOptions& options, std::stop_token stop = {});

// Points a tile may hold, as asked for or chosen. Error memory when it cannot be worked on within the memory, or on any
// of the `nodes` of a cluster, if it is one.
Result<std::uint64_t> tile_limit(const JobOptions& options, const Cloud& cloud,
                                 std::span<const budget::NodeShare> nodes = {});

}  // namespace tessera
