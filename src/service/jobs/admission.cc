#include "src/service/jobs/admission.h"

#include <chrono>
#include <exception>
#include <utility>

#include "src/job/report/human.h"
#include "src/service/jobs/job_status.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"
#include "src/service/results/owners.h"

namespace tessera::service {

using std::chrono::system_clock;

Reply<std::optional<Submitted>> Admission::same_as(const proto::Inputs& inputs, const Caller& caller,
                                                   const std::string& key) {
  std::unique_lock lock(table_.mutex);
  return same_as(inputs, caller, key, lock);
}

Reply<std::optional<Submitted>> Admission::same_as(const proto::Inputs& inputs, const Caller& caller,
                                                   const std::string& key, std::unique_lock<std::mutex>& lock) {
  const std::optional<Submitted> none;
  if (key.empty()) return none;
  const auto known = [&] { return table_.by_key.find({caller.name, key}); };
  table_.arrived.wait(lock,
                      [&] { return known() == table_.by_key.end() || !table_.jobs.at(known()->second)->arriving; });
  const auto found = known();
  if (found == table_.by_key.end()) return none;
  const Job& job = *table_.jobs.at(found->second);
  if (same_inputs(job.record, inputs)) return std::optional(Submitted{status_of(job), false});
  return problem(422,
                 "this idempotency key was sent before with other inputs, for job " + found->second + "; use a new key",
                 Errc::usage);
}

Reply<Submitted> Admission::accept(proto::JobRecord record, const Caller& caller, const std::string& note) {
  std::unique_lock lock(table_.mutex);
  BOOST_OUTCOME_TRY(same, same_as(record.inputs(), caller, record.idempotency_key(), lock));
  if (same) return *std::move(same);
  BOOST_OUTCOME_TRY(job, admit(std::move(record), caller));
  lock.unlock();
  Status added = success();
  try {
    added = table_.store.add(job->record);
  } catch (const std::exception& thrown) {  // requests that wait for the job's key must be told
    added = error(Errc::internal, thrown.what());
  }
  if (added && !note.empty()) table_.log(job->record.id(), note);
  return welcome(job, added);
}

// Gives the job an id, a place and its key; no event is sent. REQUIRES: the table's `mutex` is held.
Reply<std::shared_ptr<Job>> Admission::admit(proto::JobRecord record, const Caller& caller) {
  record.set_id(table_.ids.next(system_clock::now()));
  record.set_place(table_.next_place++);
  record.set_state(job_state::accepted);
  if (makes_result(record.inputs()) && record.triangulation().empty()) record.set_triangulation(record.id());
  record.set_created(time_text(system_clock::now()));
  record.set_updated(record.created());
  if (const auto against = conflict(record, caller)) return *against;
  const auto job = std::make_shared<Job>();
  job->record = std::move(record);
  job->arriving = true;
  const auto& id = job->record.id();
  table_.jobs[id] = job;
  table_.active.insert(id);
  if (!job->record.idempotency_key().empty()) table_.by_key[{job->record.caller(), job->record.idempotency_key()}] = id;
  return job;
}

Reply<Submitted> Admission::welcome(const std::shared_ptr<Job>& job, const Status& added) {
  const std::lock_guard lock(table_.mutex);
  const auto& record = job->record;
  job->arriving = false;
  table_.arrived.notify_all();
  if (!added) {
    table_.jobs.erase(record.id());
    table_.active.erase(record.id());
    table_.by_key.erase({record.caller(), record.idempotency_key()});
    return problem_of(added.error());
  }
  table_.waiting[record.place()] = record.id();
  table_.tell_status(*job);
  table_.waiting_changed.notify_all();
  return Submitted{status_of(*job), true};
}

std::optional<proto::Problem> Admission::conflict(const proto::JobRecord& job, const Caller& caller) {
  if (makes_result(job.inputs()) || changes_result(job.inputs()))
    if (auto against = live_result(job.triangulation())) return against;
  if (auto against = beside_others(job)) return against;
  return in_its_place(job, caller);
}

std::optional<proto::Problem> Admission::beside_others(const proto::JobRecord& job) const {
  const auto& inputs = job.inputs();
  const auto& name = job.triangulation();
  const auto output = export_output(inputs);
  const auto second = second_result_read(inputs);
  const auto clash = [](const std::string& detail) { return problem(409, detail, Errc::usage); };
  const auto works_on = [&](const std::string& result, const std::string& id) {
    return clash("triangulation '" + result + "': job " + id + " works on it; wait for that job to end, or dismiss it");
  };
  std::uint64_t of_caller = 0, bytes_of_caller = inputs.ByteSizeLong(), queued = table_.waiting.size();
  for (const auto& id : table_.active) {
    const Job& other = *table_.jobs.at(id);
    // An ended job works on nothing, even if its thread has not let go of it yet.
    if (id == job.id() || other.is(job_state::successful) || other.is(job_state::failed)) continue;
    if (other.arriving) ++queued;
    if (other.waits_or_runs() && other.record.caller() == job.caller()) {
      ++of_caller;
      bytes_of_caller += other.record.inputs().ByteSizeLong();
    }
    const auto& others_name = other.record.triangulation();
    const auto& others = other.record.inputs();
    // A job that makes a result of another one needs that one to stay as it is.
    const bool replaces_second = makes_result(others) || (makes_result(inputs) && changes_result(others));
    if (!second.empty() && others_name == second && replaces_second) return works_on(second, id);
    if (name.empty()) continue;
    const bool replaces = makes_result(inputs) || (makes_result(others) && changes_result(inputs));
    if (replaces && second_result_read(others) == name) return works_on(name, id);
    if (others_name != name) continue;
    // A job that makes a triangulation must be alone on it. Others may read it together, also while one of them changes
    // it, because the change becomes a new version; but they may not write the same export.
    if (makes_result(inputs) || makes_result(other.record.inputs())) return works_on(name, id);
    if (changes_result(inputs) && changes_result(other.record.inputs()))
      return clash("triangulation '" + name + "': job " + id + " changes it; wait for that job to end");
    if (output && export_output(other.record.inputs()) == output)
      return clash("output: job " + id + " already writes the export '" + *output +
                   "'; wait for that job, or choose another name");
  }
  if (queued >= table_.limits.queued)
    return problem(
        429, grouped(queued) + " jobs wait already, which is the most that may wait (limits.queued); try again later",
        Errc::io);
  if (bytes_of_caller > inputs_of_caller_bytes_max)
    return problem(429,
                   "the inputs of all jobs of " + job.caller() + " that wait or run would take " +
                       human_bytes(bytes_of_caller) + "; at most " + human_bytes(inputs_of_caller_bytes_max) +
                       " are allowed: name folders or patterns instead of files, or wait until jobs have ended",
                   Errc::io);
  if (of_caller >= table_.limits.jobs_of_a_caller)
    return problem(429,
                   grouped(of_caller) + " jobs of " + job.caller() +
                       " wait or run, which is the most that a caller may have (limits.jobs); wait until one has ended",
                   Errc::io);
  return std::nullopt;
}

std::optional<proto::Problem> Admission::in_its_place(const proto::JobRecord& job, const Caller& caller) {
  const auto& inputs = job.inputs();
  const auto& name = job.triangulation();
  // To replace is to remove, so a caller needs the same right for both.
  const auto judge = [&](const std::string& what, const Result<std::string>& owner) -> std::optional<proto::Problem> {
    if (!overwrites(inputs)) return problem(409, "output: " + what + "; overwrite: true replaces it", Errc::usage);
    if (!owner) return problem_of(owner.error());
    if (may_remove(owner.value(), caller)) return std::nullopt;
    return problem(403, "output: " + what + "; only its owner or an admin may replace it", Errc::usage);
  };
  if (makes_result(inputs) && !name.empty()) {
    const auto taken = [&]() -> Result<bool> {
      BOOST_OUTCOME_TRY(there, folders_.exists(name));
      if (!there) return false;
      BOOST_OUTCOME_TRY(own, folders_.made_by(name, job.id()));
      return !own;
    }();
    if (!taken) return problem_of(taken.error());
    if (taken.value()) return judge("there is a triangulation called '" + name + "' already", owner_of_result(name));
  }
  if (changes_result(inputs)) {
    const auto owner = owner_of_result(name);
    if (!owner) return problem_of(owner.error());
    if (may_remove(owner.value(), caller)) return std::nullopt;
    return problem(403, "triangulation: only the owner of '" + name + "' or an admin may change it", Errc::usage);
  }
  const auto output = export_output(inputs);
  const auto taken = output ? folders_.export_exists(name, *output) : Result<bool>(false);
  if (!taken) return problem_of(taken.error());
  if (taken.value())
    return judge("'" + name + "' has an export called '" + *output + "' already", folders_.export_owner(name, *output));
  return std::nullopt;
}

std::optional<proto::Problem> Admission::live_result(std::string_view name) const {
  if (!is_live_ || !is_live_(name)) return std::nullopt;
  return problem(409,
                 "triangulation '" + std::string(name) +
                     "' is live, so it is changed only by points that are added and removed; start the daemon without "
                     "keeping it in memory first",
                 Errc::usage);
}

Result<std::string> Admission::owner_of_result(const std::string& name) {
  BOOST_OUTCOME_TRY(maker, folders_.maker(name));
  if (!maker.owner.empty()) return maker.owner;
  const auto job = table_.jobs.find(maker.job);  // results from before manifests had the owner
  return job == table_.jobs.end() ? std::string() : job->second->record.caller();
}

}  // namespace tessera::service
