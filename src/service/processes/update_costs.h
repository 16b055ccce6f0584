// What a change of a result would cost.
#pragma once

#include <optional>

#include "service.pb.h"
#include "src/service/processes/workshop.h"
#include "src/service/reply.h"

namespace tessera::service {

// Estimates the cost by the tiles that may have removed or new points, and those that touch them. Reads source indices,
// and new points if they are few; nothing else of tiles and inputs but headers. What cannot be known so soon is told in
// the estimate's reason. `refused` gets the problem of a change that surely costs more than is allowed.
Reply<proto::Estimate> estimate_update(const Workshop& shop, const proto::Inputs& inputs,
                                       std::optional<proto::Problem>& refused);

}  // namespace tessera::service
