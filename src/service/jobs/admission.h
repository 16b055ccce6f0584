// Decides whether a job may wait or run beside the others, and accepts it.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "job_record.pb.h"
#include "src/base/result.h"
#include "src/service/caller.h"
#include "src/service/jobs/job_table.h"
#include "src/service/processes/processes_backend.h"
#include "src/service/reply.h"
#include "src/service/results/result_folders.h"

namespace tessera::service {

class Admission {
 public:
  // Whether a result is kept in memory and changed there. Then jobs may read the result, and not change or replace it.
  using IsLive = std::function<bool(std::string_view name)>;
  Admission(JobTable& table, ResultFolders& folders, IsLive is_live = {})
      : table_(table), folders_(folders), is_live_(std::move(is_live)) {}

  // The job that was accepted before with the same key and the same inputs; nothing when there is none. 422 for a job
  // with the same key and other inputs. Waits for a job with this key that is just arriving.
  Reply<std::optional<Submitted>> same_as(const proto::Inputs& inputs, const Caller& caller, const std::string& key);
  // Accepts the job: gives it an id and its place, and writes it to disk. Returns the earlier job as same_as() does, if
  // another request was faster. `note` is the first line of the job's log; may be empty. The problems of conflict().
  Reply<Submitted> accept(proto::JobRecord record, const Caller& caller, const std::string& note);

  // REQUIRES, for the functions below: the table's `mutex` is held.
  //
  // Why the job cannot wait or run beside the other jobs now, or exceeds the caller's limits: 409, 429; or why it may
  // not replace an existing result or export: 409, 403.
  std::optional<proto::Problem> conflict(const proto::JobRecord& job, const Caller& caller);
  // The owner of a result, who may remove it; empty when unknown.
  Result<std::string> owner_of_result(const std::string& name);
  // Why a live result is not removed, replaced or changed otherwise; nothing for other results. Needs no lock.
  std::optional<proto::Problem> live_result(std::string_view name) const;

 private:
  Reply<std::optional<Submitted>> same_as(const proto::Inputs& inputs, const Caller& caller, const std::string& key,
                                          std::unique_lock<std::mutex>& lock);
  Reply<std::shared_ptr<Job>> admit(proto::JobRecord record, const Caller& caller);
  // Call this when the job's record is on disk, or could not be written.
  Reply<Submitted> welcome(const std::shared_ptr<Job>& job, const Status& added);
  std::optional<proto::Problem> beside_others(const proto::JobRecord& job) const;
  std::optional<proto::Problem> in_its_place(const proto::JobRecord& job, const Caller& caller);

  JobTable& table_;
  ResultFolders& folders_;
  IsLive is_live_;
};

}  // namespace tessera::service
