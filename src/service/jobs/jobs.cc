#include "src/service/jobs/jobs.h"

#include <fcntl.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/service/jobs/job_status.h"
#include "src/service/jobs/job_tiles.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"

namespace tessera::service {
namespace {

using std::chrono::system_clock;

bool may_change(const proto::JobRecord& record, const Caller& caller) {
  return caller.role >= Role::admin || (caller.role >= Role::submit && caller.name == record.caller());
}

proto::Problem not_yours(const proto::JobRecord& record) {
  return problem(403, "job " + record.id() + " belongs to another caller: only its submitter or an admin may do this",
                 Errc::usage);
}

class Handle final : public Subscription {
 public:
  Handle(Events& events, std::shared_ptr<Events::Listener> listener)
      : events_(events), listener_(std::move(listener)) {}
  ~Handle() override { events_.leave(listener_); }

 private:
  Events& events_;
  std::shared_ptr<Events::Listener> listener_;
};

}  // namespace

Reply<proto::JobList> Jobs::list(const JobQuery& query) {
  const auto wanted = [](const std::vector<std::string>& among, const std::string& value) {
    return among.empty() || std::find(among.begin(), among.end(), value) != among.end();
  };
  proto::JobList list;
  const std::lock_guard lock(table_.mutex);
  std::uint64_t matched = 0;
  for (auto job = table_.jobs.rbegin(); job != table_.jobs.rend(); ++job) {
    const auto& record = job->second->record;
    if (!wanted(query.states, record.state()) || !wanted(query.processes, process_of(record.inputs()))) continue;
    ++matched;
    if (!query.after.empty() && job->first >= query.after) continue;
    if (static_cast<std::uint32_t>(list.jobs_size()) < query.limit) *list.add_jobs() = status_of(*job->second);
  }
  list.set_number_matched(matched);
  return list;
}

Reply<proto::StatusInfo> Jobs::status(std::string_view id) {
  const std::lock_guard lock(table_.mutex);
  BOOST_OUTCOME_TRY(job, table_.find(id));
  return status_of(*job);
}

Reply<proto::StatusInfo> Jobs::dismiss(std::string_view id, const Caller& caller) {
  const std::lock_guard changes(table_.changing);
  std::unique_lock lock(table_.mutex);
  BOOST_OUTCOME_TRY(job, table_.find(id));
  if (!may_change(job->record, caller)) return not_yours(job->record);
  if (job->waits_or_runs()) {
    lock.unlock();
    const auto changed = table_.change(*job, JobTable::Need::written, [](proto::JobRecord& record) {
      record.set_state(job_state::dismissed);
      record.set_finished(time_text(system_clock::now()));
      record.set_message("was dismissed, and can be resumed");
    });
    if (!changed) return problem_of(changed.error());
    lock.lock();
    table_.waiting.erase(job->record.place());
    ++table_.since_start.dismissed;
    if (job->running) {
      job->running->ledger.stop();
    } else {
      table_.active.erase(job->record.id());
    }
    return status_of(*job);
  }
  // The job's thread needs `changing` to let go; a job that was dismissed a moment ago still has its thread.
  if (job->running)
    return problem(409, "job " + std::string(id) + " is still stopping: try again in a moment", Errc::usage);
  auto last = status_of(*job);
  last.set_message("was removed");
  lock.unlock();
  if (const auto gone = table_.forget(job); !gone) return problem_of(gone.error());
  return last;
}

Reply<proto::StatusInfo> Jobs::resume(std::string_view id, const Caller& caller) {
  const std::lock_guard changes(table_.changing);
  std::unique_lock lock(table_.mutex);
  BOOST_OUTCOME_TRY(job, table_.find(id));
  if (!may_change(job->record, caller)) return not_yours(job->record);
  if (job->waits_or_runs()) return status_of(*job);
  if (job->damaged) return problem(409, job->record.message(), Errc::corrupt);
  if (job->is(job_state::successful))
    return problem(409, "job " + std::string(id) + " is successful: there is nothing to resume", Errc::usage);
  auto record = job->record;
  if (const auto against = admission_.conflict(record, caller)) return *against;
  const auto place = table_.next_place++;
  lock.unlock();
  const auto changed = table_.change(*job, JobTable::Need::written, [&](proto::JobRecord& resumed) {
    resumed.set_state(job_state::accepted);
    resumed.set_place(place);
    resumed.set_deaths(0);
    resumed.clear_finished();
    resumed.clear_problem();
    resumed.set_message("waits to go on");
  });
  if (!changed) return problem_of(changed.error());
  lock.lock();
  table_.active.insert(record.id());
  table_.waiting[place] = record.id();
  table_.waiting_changed.notify_all();
  return status_of(*job);
}

Reply<ServedFile> Jobs::log(std::string_view id) {
  {
    const std::lock_guard lock(table_.mutex);
    BOOST_OUTCOME_TRYV(table_.find(id));
  }
  const auto path = job_log_file(table_.store.folder(std::string(id)));
  auto handle = open_handle(path, O_RDONLY | O_NOFOLLOW);
  if (!handle) return problem_of(handle.error());
  auto file = served(std::move(handle).value(), path, "text/plain; charset=utf-8", "");
  if (!file) return problem_of(file.error());
  return file.value();
}

Reply<ServedFile> Jobs::report(std::string_view id) {
  std::string name;
  {
    const std::lock_guard lock(table_.mutex);
    BOOST_OUTCOME_TRY(job, table_.find(id));
    if (!job->is(job_state::successful)) return result_not_ready(id, job->record.state());
    if (!job->record.inputs().has_triangulate())
      return problem(404, "job " + std::string(id) + " has no report: only jobs of the process triangulate make one",
                     Errc::usage);
    name = job->record.triangulation();
  }
  BOOST_OUTCOME_TRYV(still_made_by(id, name));
  return folders_.file(name, report_file("").string());
}

Reply<void> Jobs::still_made_by(std::string_view id, const std::string& name) {
  const auto own = folders_.made_by(name, std::string(id));
  if (!own) return problem_of(own.error());
  if (!own.value())
    return problem(410, "the triangulation of job " + std::string(id) + " was removed or replaced", Errc::usage);
  return success();
}

Reply<proto::JobTiles> Jobs::tiles(std::string_view id, bool with_layout) {
  proto::JobTiles tiles;
  std::shared_ptr<Running> running;
  std::string state, name;
  {
    const std::lock_guard lock(table_.mutex);
    BOOST_OUTCOME_TRY(job, table_.find(id));
    if (!job->record.inputs().has_triangulate())
      return problem(404, "job " + std::string(id) + " has no tiles: only jobs of the process triangulate have tiles",
                     Errc::usage);
    state = job->record.state();
    name = job->record.triangulation();
    if (job->is(job_state::running)) running = job->running;
  }
  tiles.set_job_id(std::string(id));
  if (running) {
    tell_running(running->progress, with_layout, tiles);
    return tiles;
  }
  if (state != job_state::successful)
    return tiles;  // nothing is known of them yet; a watcher may learn it a moment later
  const auto manifest = folders_.manifest(name);
  BOOST_OUTCOME_TRYV(still_made_by(id, name));
  if (!manifest)
    return problem(410, "the triangulation of job " + std::string(id) + " was removed or replaced", Errc::usage);
  if (const auto told = tell_stored(*manifest.value(), with_layout, tiles); !told) return problem_of(told.error());
  return tiles;
}

Reply<std::string> Jobs::outcome(std::string_view id) {
  {
    const std::lock_guard lock(table_.mutex);
    BOOST_OUTCOME_TRY(job, table_.find(id));
    if (job->waits_or_runs()) return result_not_ready(id, job->record.state());
    if (job->is(job_state::failed)) return job->record.problem();
    if (job->is(job_state::dismissed))
      return problem(410, "job " + std::string(id) + " was dismissed; it can be resumed", Errc::interrupted);
  }
  const auto bytes = read_whole(job_outcome_file(table_.store.folder(std::string(id))));
  if (!bytes) return problem_of(bytes.error());
  return std::string(as_text(bytes.value()));
}

Reply<std::unique_ptr<Subscription>> Jobs::subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) {
  if (!id.empty()) {
    const std::lock_guard lock(table_.mutex);
    BOOST_OUTCOME_TRYV(table_.find(id));
  }
  const auto statuses = [&] {
    const std::lock_guard lock(table_.mutex);
    return table_.statuses(id);
  };
  auto listener = table_.events.listen(std::string(id), last, std::move(on_event), statuses);
  return std::unique_ptr<Subscription>(std::make_unique<Handle>(table_.events, std::move(listener)));
}

}  // namespace tessera::service
