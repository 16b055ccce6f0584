// The implementation of Service: its jobs, the threads that work on them, and the rules of access.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "actors/engine/engine.h"
#include "job_record.pb.h"
#include "src/base/ledger.h"
#include "src/base/progress.h"
#include "src/service/questions/collections.h"
#include "src/service/data_folder.h"
#include "src/service/jobs/events.h"
#include "src/service/jobs/job_state.h"
#include "src/service/jobs/job_store.h"
#include "src/service/naming.h"
#include "src/service/questions/questions.h"
#include "src/service/results/result_folders.h"
#include "src/service/inputs/roots.h"
#include "src/service/service.h"
#include "src/service/inputs/uploads.h"
#include "src/service/processes/work.h"

namespace tessera {

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
  bool arriving = false;             // its record is being written for the first time: only submit() knows the job

  bool is(const char* state) const { return record.state() == state; }
  bool waits_or_runs() const { return is(job_state::accepted) || is(job_state::running); }
};

// There are two locks, taken in this order. A thread that changes a job's record holds `changing` while the record is
// written. `mutex` guards memory, and is never held during writes to disk or calls of other objects. Readers need only
// `mutex`; changes of shared data need both. A new job needs only `mutex`: it gets its id, its place and its key at
// once, and no other thread knows it before it is on disk. So many new jobs can be written at a time.
struct Service::Impl {
  Impl(ServiceOptions given, std::unique_ptr<DataFolder> held, Roots opened_roots,
       std::unique_ptr<Events> opened_events, std::unique_ptr<Engine> opened_engine);
  ~Impl();
  Status load();
  void add_damaged(const std::string& id, const std::string& why);
  void recover(Job& job);
  void begin();  // starts the threads
  void tell(const std::string& line) const {
    if (options.log) options.log(line);
  }

  // service_work.cc
  void work();
  std::shared_ptr<Job> take();
  std::shared_ptr<Job> next() const;
  bool start(const std::shared_ptr<Job>& job, const std::shared_ptr<Running>& running);
  void end(const std::shared_ptr<Job>& job, Reply<JobDone> done);
  void forgive_deaths();
  Reply<JobDone> finish(const proto::JobRecord& job, Reply<JobDone> done, std::filesystem::path& replaced);
  // service.cc
  void tick();
  void tell_progress();
  // Tiles of running jobs that are not stored yet.
  std::map<std::string, std::uint64_t> tiles_by_node();
  void write_again();
  // Forget ended jobs: those older than the retention, and for each caller those beyond the allowed number.
  void forget_old();
  void forget_beyond();
  std::vector<std::shared_ptr<Job>> ended_jobs() const;
  // REQUIRES: `changing` is held.
  void forget_or_tell(const std::shared_ptr<Job>& job);

  // service_jobs.cc. REQUIRES: `changing` is held for change() and forget(); `mutex` for status_of() and find().
  enum class Need : bool { written, done };  // an error changes nothing; or it changes, and is written later
  Status change(Job& job, Need need, const std::function<void(proto::JobRecord&)>& how);
  Status forget(const std::shared_ptr<Job>& job);
  void log(const std::string& id, const std::string& text);
  // Names inputs as callers name them, not by their paths on this machine.
  proto::Problem in_callers_words(proto::Problem problem) const;
  proto::StatusInfo status_of(const Job& job) const;
  Reply<std::shared_ptr<Job>> find(std::string_view id) const;
  void tell_status(const Job& job);

  // service_submit.cc
  //
  // REQUIRES: `mutex` is held. Gives the job an id, a place and its key; no event is sent.
  Reply<std::shared_ptr<Job>> admit(proto::JobRecord record, const Caller& caller);
  // Call this when the job's record is on disk, or could not be written.
  Reply<Service::Submitted> welcome(const std::shared_ptr<Job>& job, const Status& added);
  std::optional<proto::Problem> check_inputs(const proto::Inputs& inputs, std::string& triangulation) const;
  std::optional<proto::Problem> check_options(const proto::Inputs& inputs) const;
  Reply<proto::Estimate> costs(const proto::TriangulateInputs& inputs, std::optional<proto::Problem>& refused) const;
  Reply<proto::Estimate> costs(const proto::Inputs& inputs, std::optional<proto::Problem>& refused);
  // REQUIRES: `mutex` is held. Why the job cannot wait or run beside the other jobs now, or exceeds the caller's
  // limits.
  std::optional<proto::Problem> conflict(const proto::JobRecord& job, const Caller& caller);
  // REQUIRES: `mutex` is held. Why an existing result or export cannot be replaced by the job's.
  std::optional<proto::Problem> in_its_place(const proto::JobRecord& job, const Caller& caller);
  // REQUIRES: `lock` is that of `mutex`. Waits for a job with this key that is just arriving.
  std::optional<Service::Submitted> same_as(const proto::Inputs& inputs, const Caller& caller, const std::string& key,
                                            std::unique_lock<std::mutex>& lock, std::optional<proto::Problem>& other);

  // service_results.cc. REQUIRES: `mutex` is held. The owner of a result, who may remove it; empty when unknown.
  Result<std::string> owner_of_result(const std::string& name);

  const ServiceOptions options;
  const JobShare share;
  const std::unique_ptr<DataFolder> data_folder;
  JobStore store;
  Results results;
  Questions questions;
  Collections maps;
  Uploads uploads;
  RegionClouds clouds;
  const Roots roots;
  std::unique_ptr<Events> events;
  const std::unique_ptr<Engine> engine;
  const Workshop shop;

  std::mutex changing;
  mutable std::mutex mutex;
  std::condition_variable waiting_changed;  // with `mutex`: a job waits, or the service ends
  std::condition_variable arrived;          // with `mutex`: a job has arrived, or could not be written
  std::map<std::string, std::shared_ptr<Job>, std::less<>> jobs;
  std::set<std::string> active;                  // ids of jobs that wait or run, or that a thread still holds
  std::map<std::uint64_t, std::string> waiting;  // by place in the queue
  std::size_t held = 0;                          // jobs that threads work on
  bool held_alone = false;                       // a thread works on a job that must run alone
  std::set<std::string> unwritten;               // jobs whose record is newer than the one on disk
  std::uint64_t next_place = 1;
  std::map<std::pair<std::string, std::string>, std::string> by_key;  // caller and key: id
  std::set<std::string, std::less<>> forgotten;
  JobIds ids;
  bool one_has_ended = true;  // since the last forget_beyond(); with `changing`
  bool ending = false;
  Service::Figures since_start;
  std::map<std::string, double> phase_seconds;
  const std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point ticked = std::chrono::steady_clock::now();
  std::condition_variable tick_now;  // with `mutex`: signalled only at the end
  std::vector<std::thread> threads;
};

}  // namespace tessera
