// All that front ends know of a service.
#pragma once

#include "src/service/health_backend.h"
#include "src/service/inputs/inputs_backend.h"
#include "src/service/jobs/jobs_backend.h"
#include "src/service/live/live_backend.h"
#include "src/service/nodes_backend.h"
#include "src/service/processes/processes_backend.h"
#include "src/service/questions/questions_backend.h"
#include "src/service/results/results_backend.h"

namespace tessera::service {

// The objects must outlive whoever holds this.
struct Backend {
  ProcessesBackend& processes;
  JobsBackend& jobs;
  ResultsBackend& results;
  QuestionsBackend& questions;
  InputsBackend& inputs;
  NodesBackend& nodes;
  HealthBackend& health;
  LiveBackend& live;
};

}  // namespace tessera::service
