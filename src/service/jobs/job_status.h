// What callers are told of a job.
#pragma once

#include "service.pb.h"
#include "src/service/jobs/job.h"

namespace tessera::service {

// The state of the job and, while it runs, its progress. REQUIRES: the lock of the table that holds the job.
proto::StatusInfo status_of(const Job& job);

}  // namespace tessera::service
