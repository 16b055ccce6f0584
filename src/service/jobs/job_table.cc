#include "src/service/jobs/job_table.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/service/jobs/deaths.h"
#include "src/service/jobs/job_status.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"

namespace tessera::service {

using std::chrono::system_clock;

JobTable::JobTable(std::filesystem::path data, StagingFolder& staging, Events& opened, const ServiceLimits& given,
                   JobTableHooks hooks)
    : limits(given), store(std::move(data), staging), events(opened), hooks_(std::move(hooks)) {}

Result<std::set<std::string>> JobTable::load() {
  BOOST_OUTCOME_TRY(loaded, store.load());
  for (const auto& warning : loaded.warnings) warn(warning);
  std::set<std::string> known;
  for (auto& record : loaded.jobs) {
    known.insert(record.id());
    auto job = std::make_shared<Job>();
    job->record = std::move(record);
    auto& kept = job->record;
    next_place = std::max(next_place, kept.place() + 1);
    if (!kept.idempotency_key().empty()) by_key[{kept.caller(), kept.idempotency_key()}] = kept.id();
    jobs[kept.id()] = job;
    if (job->is(job_state::running)) recover(*job);
    if (job->is(job_state::accepted)) {
      waiting[kept.place()] = kept.id();
      active.insert(kept.id());
    }
  }
  for (const auto& [id, why] : loaded.damaged) {
    known.insert(id);
    add_damaged(id, why);
  }
  forgotten = {loaded.forgotten.begin(), loaded.forgotten.end()};
  ids.seen(loaded.last_id);
  // Jobs whose record cannot be read are known, too, so that nothing of theirs is removed.
  FolderReader reader(jobs_folder(store.data()));
  while (const char* name = reader.next()) known.insert(name);
  if (reader.error()) return io_error(jobs_folder(store.data()), "cannot be read", reader.error().value());
  return known;
}

// An accepted job must not be reported as missing.
void JobTable::add_damaged(const std::string& id, const std::string& why) {
  warn(why);
  auto job = std::make_shared<Job>();
  job->damaged = true;
  job->record.set_id(id);
  job->record.set_state(job_state::failed);
  *job->record.mutable_problem() = problem(500, why, Errc::corrupt);
  job->record.set_message(job->record.problem().detail());
  jobs[id] = std::move(job);
}

// Recovers a job whose record says that it runs. Its process has died, because a process that ends properly records
// that its jobs wait.
void JobTable::recover(Job& job) {
  const auto deaths = job.record.deaths() + 1;
  const auto waits = [&](proto::JobRecord& record) {
    record.set_deaths(deaths);
    record.set_state(job_state::accepted);
    record.set_message("waits to go on after a restart of the daemon");
  };
  const auto fails = [&](proto::JobRecord& record) {
    *record.mutable_problem() =
        problem(500,
                "the daemon died " + std::to_string(deaths) +
                    " times in a row while this job ran; the job starts again only when it is resumed",
                Errc::internal);
    record.set_deaths(0);
    record.set_finished(time_text(system_clock::now()));
    record.set_state(job_state::failed);
    record.set_message(record.problem().detail());
  };
  const auto changed = deaths < limits.deaths ? change(job, Need::done, waits) : change(job, Need::done, fails);
  static_cast<void>(changed);  // Need::done: if it cannot be written now, it is written later
}

Reply<std::shared_ptr<Job>> JobTable::find(std::string_view id) const {
  if (const auto found = jobs.find(id); found != jobs.end() && !found->second->arriving) return found->second;
  if (forgotten.contains(id)) return problem(410, "job " + std::string(id) + " was removed", Errc::usage);
  return no_such_job(id);
}

void JobTable::tell_status(const Job& job) {
  proto::Event event;
  event.set_job_id(job.record.id());
  event.set_kind("status");
  *event.mutable_status() = status_of(job);
  event.set_time(job.record.updated());
  events.tell(std::move(event));
}

std::uint64_t JobTable::memory_used() const {
  std::uint64_t bytes = 0;
  for (const auto& id : active) {
    if (const auto& running = jobs.at(id)->running) bytes += running->progress.memory_bytes;
  }
  return bytes;
}

std::vector<proto::Event> JobTable::statuses(std::string_view id) const {
  std::vector<proto::Event> told;
  for (const auto& [name, job] : jobs) {
    if ((!id.empty() && name != id) || job->arriving) continue;
    auto& event = told.emplace_back();
    event.set_job_id(name);
    event.set_kind("status");
    *event.mutable_status() = status_of(*job);
    event.set_time(job->record.updated());
  }
  return told;
}

void JobTable::log(const std::string& id, const std::string& text) {
  const std::string line = hooks_.named ? hooks_.named(text) : text;
  store.log(id, line);
  proto::Event event;
  event.set_job_id(id);
  event.set_kind("log");
  event.set_text(problem(0, line).detail());  // options get the names of fields; UTF-8
  event.set_time(time_text(system_clock::now()));
  events.tell(std::move(event));
}

proto::Problem JobTable::in_callers_words(proto::Problem problem) const {
  return hooks_.named ? reworded(std::move(problem), hooks_.named) : problem;
}

Status JobTable::change(Job& job, Need need, const std::function<void(proto::JobRecord&)>& how) {
  proto::JobRecord changed;
  {
    const std::lock_guard lock(mutex);
    changed = job.record;
  }
  const std::string before = changed.state();
  how(changed);
  changed.set_updated(time_text(system_clock::now()));
  one_has_ended |= changed.state() != job_state::accepted && changed.state() != job_state::running;
  const auto written = store.replace(changed);
  if (!written && need == Need::written) return written.error();
  // First the log: a client that hears of a job's end finds the log complete, and a watcher's stream ends with the
  // status.
  if (before != changed.state()) {
    const std::string said = changed.state() + (changed.message().empty() ? "" : ": " + changed.message());
    log(changed.id(), said);
    const std::string line =
        "job " + changed.id() + " (" + process_of(changed.inputs()) + ") of " + changed.caller() + ": " + said;
    if (changed.state() == job_state::failed) warn(line);
    if (changed.state() != job_state::failed && hooks_.note) hooks_.note(line);
  }
  {
    const std::lock_guard lock(mutex);
    if (!written) {
      unwritten.insert(changed.id());
    } else {
      unwritten.erase(changed.id());
    }
    job.record = changed;
    tell_status(job);
  }
  return success();
}

Status JobTable::forget(const std::shared_ptr<Job>& job) {
  const proto::JobRecord record = job->record;
  if (hooks_.drop) {
    BOOST_OUTCOME_TRYV(hooks_.drop(record));
  }
  BOOST_OUTCOME_TRYV(store.forget(record.id()));
  const std::lock_guard lock(mutex);
  jobs.erase(record.id());
  unwritten.erase(record.id());
  by_key.erase({record.caller(), record.idempotency_key()});
  forgotten.insert(record.id());
  return success();
}

void JobTable::tell_progress() {
  const std::lock_guard lock(mutex);
  for (const auto& id : active) {
    Job& job = *jobs.at(id);
    if (!job.running || !job.is(job_state::running)) continue;
    proto::Event event;
    event.set_job_id(id);
    event.set_kind("progress");
    *event.mutable_status() = status_of(job);
    // Only changes are sent. The remaining and elapsed times, which always change, are not compared.
    proto::StatusInfo compared = event.status();
    compared.clear_eta_s();
    compared.mutable_figures()->clear_elapsed_s();
    auto text = compared.SerializeAsString();
    if (text == job.told) continue;
    job.told = std::move(text);
    event.set_time(time_text(system_clock::now()));
    events.tell(std::move(event));
  }
}

void JobTable::write_again() {
  const std::lock_guard changes(changing);
  std::vector<std::shared_ptr<Job>> late;
  {
    const std::lock_guard lock(mutex);
    for (const auto& id : unwritten) late.push_back(jobs.at(id));
  }
  for (const auto& job : late) {
    if (!store.replace(job->record)) return;  // tried again the next time
    const std::lock_guard lock(mutex);
    unwritten.erase(job->record.id());
  }
}

void JobTable::forgive_deaths(const std::function<std::uint64_t(const Progress&)>& lasting) {
  const std::lock_guard changes(changing);
  std::vector<std::pair<std::shared_ptr<Job>, std::uint64_t>> got_on;
  {
    const std::lock_guard lock(mutex);
    for (const auto& id : active) {
      const auto& job = jobs.at(id);
      if (!job->running || !job->is(job_state::running)) continue;
      const Progress& progress = job->running->progress;
      const std::uint64_t done = lasting(progress);
      if (gets_on(job->record, done, progress.tiles_total)) got_on.emplace_back(job, done);
    }
  }
  for (const auto& [job, done] : got_on) {
    const auto changed = change(*job, Need::done, [done = done](proto::JobRecord& record) {
      record.set_deaths(0);
      record.set_reached(done);
    });
    static_cast<void>(changed);  // as in recover()
  }
}

void JobTable::forget_ended_before(system_clock::time_point time) {
  const std::lock_guard changes(changing);
  for (const auto& job : ended_jobs())
    if (time_of(job->record.finished()) < time) forget_or_warn(job);
}

void JobTable::forget_beyond() {
  const std::lock_guard changes(changing);
  if (!std::exchange(one_has_ended, false)) return;
  std::map<std::string, std::vector<std::shared_ptr<Job>>> by_caller;
  for (const auto& job : ended_jobs()) by_caller[job->record.caller()].push_back(job);
  for (auto& [caller, ended] : by_caller) {
    // The last first.
    std::sort(ended.begin(), ended.end(), [](const auto& a, const auto& b) {
      return std::pair(time_of(a->record.finished()), a->record.id()) >
             std::pair(time_of(b->record.finished()), b->record.id());
    });
    std::uint64_t count = 0, bytes = 0;
    for (const auto& job : ended) {
      bytes += job->record.inputs().ByteSizeLong();
      if (++count > limits.ended_of_a_caller || bytes > inputs_of_caller_bytes_max) forget_or_warn(job);
    }
  }
}

std::vector<std::shared_ptr<Job>> JobTable::ended_jobs() const {
  std::vector<std::shared_ptr<Job>> ended;
  const std::lock_guard lock(mutex);
  for (const auto& [id, job] : jobs)
    if (!job->waits_or_runs() && !job->running && !job->damaged && !unwritten.contains(id)) ended.push_back(job);
  return ended;
}

void JobTable::forget_or_warn(const std::shared_ptr<Job>& job) {
  if (const auto gone = forget(job); !gone) warn(gone.error().where);
}

}  // namespace tessera::service
