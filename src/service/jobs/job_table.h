// The jobs of a service, in memory and on disk. The table knows their records and their order. It knows neither what
// jobs compute nor the threads that work on them.
//
// There are two locks, taken in this order. A thread that changes a job's record holds `changing` while the record is
// written. `mutex` guards memory, and is never held during writes to disk or calls of other objects. Readers need only
// `mutex`; changes of shared data need both. A new job needs only `mutex`: it gets its id, its place and its key at
// once, and no other thread knows it before it is on disk. So many new jobs can be written at a time.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/service/health_backend.h"
#include "src/service/jobs/events.h"
#include "src/service/jobs/job.h"
#include "src/service/jobs/job_store.h"
#include "src/service/limits.h"
#include "src/service/naming.h"
#include "src/service/reply.h"

namespace tessera::service {

// What the table calls. Each may be empty.
struct JobTableHooks {
  std::function<void(const std::string&)> warn;  // gets sentences about failures
  std::function<void(const std::string&)> note;  // gets lines about normal events
  // Names inputs in a sentence as callers name them.
  std::function<std::string(const std::string&)> named;
  // Removes the files that only this job knows, before the job is forgotten. Error io.
  std::function<Status(const proto::JobRecord&)> drop;
};

class JobTable {
 public:
  // Records are written below `data`, through `staging`.
  JobTable(std::filesystem::path data, StagingFolder& staging, Events& events, const ServiceLimits& limits,
           JobTableHooks hooks);

  // Reads the jobs of the disk. A job whose record says that it runs waits again, as its process has died; after too
  // many successive deaths it has failed. Returns the ids of all jobs, also of those whose record cannot be read.
  Result<std::set<std::string>> load();

  // REQUIRES, for the functions below: `mutex` is held.
  //
  // 404, or 410 for a job that was removed.
  Reply<std::shared_ptr<Job>> find(std::string_view id) const;
  void tell_status(const Job& job);
  // The memory that running jobs use in this process.
  std::uint64_t memory_used() const;
  // Events with the status of one job, or of all (""); for those who missed earlier events.
  std::vector<proto::Event> statuses(std::string_view id) const;

  // REQUIRES, for the functions below: `changing` is held, and `mutex` is not.
  //
  enum class Need : bool { written, done };  // an error changes nothing; or it changes, and is written later
  Status change(Job& job, Need need, const std::function<void(proto::JobRecord&)>& how);
  Status forget(const std::shared_ptr<Job>& job);

  // REQUIRES, for all others: neither lock is held.
  //
  // Adds a line to the job's log, and tells it to listeners.
  void log(const std::string& id, const std::string& text);
  void tell_progress();
  // Writes the records that could not be written before.
  void write_again();
  // Counts no deaths against jobs that got on in spite of them. `lasting` tells how many tiles of a job outlive the
  // process.
  void forgive_deaths(const std::function<std::uint64_t(const Progress&)>& lasting);
  // Forget ended jobs: those that ended before a time, and for each caller those beyond the allowed number.
  void forget_ended_before(std::chrono::system_clock::time_point time);
  void forget_beyond();
  // Names inputs in the problem as callers name them.
  proto::Problem in_callers_words(proto::Problem problem) const;
  void warn(const std::string& line) const {
    if (hooks_.warn) hooks_.warn(line);
  }

  const ServiceLimits limits;
  JobStore store;
  Events& events;

  std::mutex changing;
  mutable std::mutex mutex;
  std::condition_variable waiting_changed;  // with `mutex`: a job waits, or the service ends
  std::condition_variable arrived;          // with `mutex`: a job has arrived, or could not be written
  std::map<std::string, std::shared_ptr<Job>, std::less<>> jobs;
  std::set<std::string> active;                  // ids of jobs that wait or run, or that a thread still holds
  std::map<std::uint64_t, std::string> waiting;  // by place in the queue
  std::set<std::string> unwritten;               // jobs whose record is newer than the one on disk
  std::uint64_t next_place = 1;
  std::map<std::pair<std::string, std::string>, std::string> by_key;  // caller and key: id
  std::set<std::string, std::less<>> forgotten;
  JobIds ids;
  bool one_has_ended = true;  // since the last forget_beyond(); with `changing`
  ServiceFigures since_start;
  std::map<std::string, double> phase_seconds;

 private:
  void add_damaged(const std::string& id, const std::string& why);
  void recover(Job& job);
  std::vector<std::shared_ptr<Job>> ended_jobs() const;
  // REQUIRES: `changing` is held.
  void forget_or_warn(const std::shared_ptr<Job>& job);

  const JobTableHooks hooks_;
};

}  // namespace tessera::service
