// A job in memory: its record, and its state while a thread works on it.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "job_record.pb.h"
#include "src/base/ledger.h"
#include "src/base/progress.h"
#include "src/service/jobs/job_state.h"

namespace tessera::service {

// The state of a job while a thread works on it.
struct Running {
  explicit Running(Ledger::Bounds bounds) : ledger(std::move(bounds)) {}
  Progress progress;
  Ledger ledger;
};

struct Job {
  proto::JobRecord record;
  std::shared_ptr<Running> running;  // also of a dismissed job, until its thread has let go
  std::string told;                  // the last reported progress, as text
  bool damaged = false;              // its record cannot be read: the job can be listed and forgotten
  bool arriving = false;             // its record is being written for the first time: only its caller knows the job

  bool is(const char* state) const { return record.state() == state; }
  bool waits_or_runs() const { return is(job_state::accepted) || is(job_state::running); }
};

}  // namespace tessera::service
