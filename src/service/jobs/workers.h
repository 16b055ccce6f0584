// The threads that work on jobs: which job is next, and how it ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "src/base/ledger.h"
#include "src/service/jobs/job_table.h"
#include "src/service/processes/job_work.h"
#include "src/service/reply.h"

namespace tessera::service {

// What the threads call; all but `work` may be empty.
struct WorkersHooks {
  // Does the work of a job. An exception ends that job, and nothing else.
  std::function<Reply<JobDone>(const JobWork&)> work;
  // Gives what the job has made its name. Returns a folder for `discard`; may be empty.
  std::function<Reply<std::filesystem::path>(const proto::JobRecord&)> publish = {};
  // Removes the files of what was replaced; may take long.
  std::function<Status(const std::filesystem::path&)> discard = {};
  // True while nodes that still work on a job of before may be about to join.
  std::function<bool()> gathering = {};
  // The bounds of a job's memory and disk.
  std::function<Ledger::Bounds()> bounds = {};
};

class Workers {
 public:
  // Begins `count` threads.
  Workers(JobTable& table, WorkersHooks hooks, std::uint32_t count);
  // Interrupts running jobs, which wait to go on after a restart.
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

 private:
  void run();
  std::shared_ptr<Job> take();
  std::shared_ptr<Job> next() const;
  bool start(const std::shared_ptr<Job>& job, const std::shared_ptr<Running>& running);
  void end(const std::shared_ptr<Job>& job, Reply<JobDone> done);
  Reply<JobDone> finish(const proto::JobRecord& job, Reply<JobDone> done, std::filesystem::path& replaced);
  Reply<JobDone> guarded(const JobWork& work) const;

  JobTable& table_;
  const WorkersHooks hooks_;
  // With the table's `mutex`:
  std::size_t held_ = 0;     // jobs that threads work on
  bool held_alone_ = false;  // a thread works on a job that must run alone
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tessera::service
