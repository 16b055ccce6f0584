// What front ends ask of the processes: to do one, or to estimate its cost.
#pragma once

#include <string>
#include <string_view>

#include "service.pb.h"
#include "src/service/caller.h"
#include "src/service/reply.h"

namespace tessera::service {

struct Submitted {
  proto::StatusInfo status;
  bool fresh = true;  // the job is new
};

// Thread-safe.
class ProcessesBackend {
 public:
  virtual ~ProcessesBackend() = default;
  // Submits a job. A repeated call with the same key and inputs returns the same job; with other inputs it is 422.
  virtual Reply<Submitted> submit(const proto::Inputs& inputs, const Caller& caller,
                                  std::string_view idempotency_key = {}) = 0;
  // Estimates the cost of triangulate, region, dem, contours, density and export.
  virtual Reply<proto::Estimate> estimate(const proto::Inputs& inputs, const Caller& caller) = 0;
  // Answers short info jobs at once, with what `tessera info --json` prints. Statistics of many points and compressed
  // files take too long: 400, submit a job instead.
  virtual Reply<std::string> info(const proto::InfoInputs& inputs, const Caller& caller) = 0;
};

}  // namespace tessera::service
