// What the inputs of the process update say, and the change that they mean.
#pragma once

#include <cstdint>
#include <optional>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/delaunay/update/select_points.h"
#include "src/delaunay/update/update.h"
#include "src/service/processes/convert.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {

struct UpdateRequest {
  PointSelection selection = {};  // without polygons, files and places, for which the result is needed
  std::optional<std::uint32_t> keep = {};
  JobShare share = {};
};

// Errors: usage, with marks for options.
Result<UpdateRequest> update_request(const proto::UpdateInputs& inputs, const JobShare& share);

// The source indices that the inputs name. Errors: usage and bad_input for a file that has none; io.
Result<std::vector<PointId>> ids_to_remove(const Workshop& shop, const proto::UpdateInputs& inputs);

struct ChangeOfResult {
  ResultChange change = {};
  std::vector<Manifest::Input> inputs = {};  // of the new points
};
// Reads the new points, and finds those that are to be removed in the newest version of the result. Errors: usage, with
// marks for options; memory when the new points take more than the memory of the job; those of reading; interrupted.
Result<ChangeOfResult> read_change_of_result(const Workshop& shop, const JobWork& work, UpdateRequest request);

}  // namespace tessera::service
