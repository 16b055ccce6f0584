// Takes what callers want done: checks it, estimates its cost, and has it accepted as a job.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "src/service/jobs/admission.h"
#include "src/service/processes/processes_backend.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {

class Processes final : public ProcessesBackend {
 public:
  Processes(const Workshop& shop, Admission& admission) : shop_(shop), admission_(admission) {}

  Reply<Submitted> submit(const proto::Inputs& inputs, const Caller& caller,
                          std::string_view idempotency_key = {}) override;
  Reply<proto::Estimate> estimate(const proto::Inputs& inputs, const Caller& caller) override;
  Reply<std::string> info(const proto::InfoInputs& inputs, const Caller& caller) override;

 private:
  // `triangulation` gets the name of the result that the job makes or reads.
  std::optional<proto::Problem> check(const proto::Inputs& inputs, std::string& triangulation) const;

  const Workshop& shop_;
  Admission& admission_;
};

}  // namespace tessera::service
