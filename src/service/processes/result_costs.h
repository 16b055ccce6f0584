// Estimates of processes that read a result.
#pragma once

#include <optional>

#include "src/result/store/tile_store.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {

// Fills in what an estimate says of a refusal.
inline proto::Estimate judged(proto::Estimate estimate, const std::optional<proto::Problem>& refused) {
  if (refused) estimate.set_reason(refused->detail());
  estimate.set_accepted(!refused);
  return estimate;
}

// The problem of a process that needs heights over a plane, for a result that has none.
inline std::optional<proto::Problem> no_heights(const Manifest& manifest, const std::string& name) {
  if (manifest.dimension == 2) return std::nullopt;
  return problem(400, "triangulation: '" + name + "' is a 3D result, which has no heights over a plane", Errc::usage);
}

}  // namespace tessera::service
