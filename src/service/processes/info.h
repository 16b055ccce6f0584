// Describes input files or a result at once, while a caller waits.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "src/service/processes/workshop.h"

namespace tessera::service {

// Returns what `tessera info --json` prints.
Result<std::string> describe_inputs(const Workshop& shop, const proto::InfoInputs& inputs, const std::stop_token& stop);
// Returns a problem for inputs that take too long for a request: compressed files, and statistics of more than
// `points_max` points.
Result<std::optional<proto::Problem>> takes_too_long(const Workshop& shop, const proto::InfoInputs& inputs,
                                                     std::uint64_t points_max);

}  // namespace tessera::service
