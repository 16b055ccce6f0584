// Requests about accepted jobs.
#include <fcntl.h>

#include <algorithm>
#include <cmath>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/job/report/progress_line.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"

namespace tessera {
namespace {

using std::chrono::steady_clock;
using std::chrono::system_clock;

void add_progress(const proto::JobRecord& record, const Progress& progress, proto::StatusInfo& status) {
  const double elapsed_s = std::chrono::duration<double>(steady_clock::now() - progress.started).count();
  const auto now = look(progress, elapsed_s);
  double part = 0;
  if (record.inputs().has_triangulate()) {
    part = fraction_done(now);
    status.set_phase(name_of(now.phase));
    status.mutable_tiles()->set_total(now.tiles_total);
    status.mutable_tiles()->set_triangulated(now.tiles_triangulated);
    status.mutable_tiles()->set_asleep(now.tiles_asleep);
    status.mutable_tiles()->set_stored(now.tiles_stored);
    auto& figures = *status.mutable_figures();
    figures.set_elapsed_s(elapsed_s);
    figures.set_points_total(now.points_total);
    figures.set_points_routed(now.points_routed);
    figures.set_points_triangulated(now.points_triangulated);
    figures.set_tiles_total(now.tiles_total);
    figures.set_tiles_triangulated(now.tiles_triangulated);
    figures.set_tiles_stored(now.tiles_stored);
    figures.set_tiles_asleep(now.tiles_asleep);
    figures.set_updates_sent(now.updates_sent);
    figures.set_updates_processed(now.updates_processed);
    figures.set_points_sent(now.points_sent);
    figures.set_memory_bytes(now.memory_bytes);
    figures.set_bytes_between(now.bytes_between);
    figures.set_credit_waits(now.credit_waits);
    for (const NodeProgress& node : now.nodes) {
      auto& to = *figures.add_nodes();
      to.set_name(node.name);
      to.set_tiles(node.tiles);
      to.set_tiles_triangulated(node.tiles_triangulated);
      to.set_tiles_stored(node.tiles_stored);
      to.set_memory_bytes(node.memory_bytes);
      to.set_lost(node.lost);
    }
    status.set_memory_bytes(now.memory_bytes);
    status.set_nodes_lost(progress.nodes_lost);
  } else if (now.points_total > 0) {  // an export or a region
    part = static_cast<double>(now.points_triangulated) / static_cast<double>(now.points_total);
  }
  status.set_progress(std::clamp(static_cast<int>(std::floor(part * 100)), 0, 99));
  if (part > 0.01 && part < 1) status.set_eta_s(std::round(elapsed_s * (1 - part) / part * 10) / 10);
}

bool may_change(const proto::JobRecord& record, const Caller& caller) {
  return caller.role >= Role::admin || (caller.role >= Role::submit && caller.name == record.caller());
}

proto::Problem not_yours(const proto::JobRecord& record) {
  return problem(403, "job " + record.id() + " is another's: who submitted it or an admin may do this", Errc::usage);
}

}  // namespace

proto::StatusInfo Service::Impl::status_of(const Job& job) const {
  const auto& record = job.record;
  proto::StatusInfo status;
  status.set_job_id(record.id());
  status.set_id(record.id());
  status.set_process_id(process_of(record.inputs()));
  status.set_type("process");
  status.set_status(record.state());
  status.set_message(record.message());
  status.set_created(record.created());
  status.set_started(record.started());
  status.set_finished(record.finished());
  status.set_updated(record.updated());
  status.set_submitter(record.caller());
  status.set_points(record.points());
  status.set_nodes_lost(record.nodes_lost());
  status.set_memory_bytes(record.memory_bytes());
  status.set_triangulation(record.triangulation());
  status.set_starts(record.starts());
  status.set_resumable(!job.damaged && (job.is(job_state::failed) || job.is(job_state::dismissed)));
  if (record.has_problem()) *status.mutable_problem() = record.problem();
  if (job.is(job_state::successful)) status.set_progress(100);
  if (job.is(job_state::running) && job.running) add_progress(record, job.running->progress, status);
  return status;
}

void Service::Impl::tell_status(const Job& job) {
  proto::Event event;
  event.set_job_id(job.record.id());
  event.set_kind("status");
  *event.mutable_status() = status_of(job);
  event.set_time(job.record.updated());
  events->tell(std::move(event));
}

void Service::Impl::log(const std::string& id, const std::string& text) {
  const std::string line = roots.named(text);
  store.log(id, line);
  proto::Event event;
  event.set_job_id(id);
  event.set_kind("log");
  event.set_text(problem(0, line).detail());  // options get the names of fields; UTF-8
  event.set_time(time_text(system_clock::now()));
  events->tell(std::move(event));
}

Status Service::Impl::change(Job& job, Need need, const std::function<void(proto::JobRecord&)>& how) {
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
    if (changed.state() == job_state::failed) tell(line);
    if (changed.state() != job_state::failed && options.note) options.note(line);
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

Status Service::Impl::forget(const std::shared_ptr<Job>& job) {
  const proto::JobRecord record = job->record;
  // First the files that only this job knows.
  BOOST_OUTCOME_TRYV(results.drop_unfinished(record.id()));
  if (export_output(record.inputs())) {
    BOOST_OUTCOME_TRYV(results.drop_unfinished_export(record.triangulation(), record.id()));
  }
  BOOST_OUTCOME_TRYV(store.forget(record.id()));
  const std::lock_guard lock(mutex);
  jobs.erase(record.id());
  unwritten.erase(record.id());
  by_key.erase({record.caller(), record.idempotency_key()});
  forgotten.insert(record.id());
  return success();
}

Reply<std::shared_ptr<Job>> Service::Impl::find(std::string_view id) const {
  if (const auto found = jobs.find(id); found != jobs.end() && !found->second->arriving) return found->second;
  if (forgotten.contains(id)) return problem(410, "job " + std::string(id) + " was removed", Errc::usage);
  return no_such_job(id);
}

Reply<proto::JobList> Service::jobs(const JobQuery& query) {
  const auto wanted = [](const std::vector<std::string>& among, const std::string& value) {
    return among.empty() || std::find(among.begin(), among.end(), value) != among.end();
  };
  proto::JobList list;
  const std::lock_guard lock(impl_->mutex);
  std::uint64_t matched = 0;
  for (auto job = impl_->jobs.rbegin(); job != impl_->jobs.rend(); ++job) {
    const auto& record = job->second->record;
    if (!wanted(query.states, record.state()) || !wanted(query.processes, process_of(record.inputs()))) continue;
    ++matched;
    if (!query.after.empty() && job->first >= query.after) continue;
    if (static_cast<std::uint32_t>(list.jobs_size()) < query.limit) *list.add_jobs() = impl_->status_of(*job->second);
  }
  list.set_number_matched(matched);
  return list;
}

Reply<proto::StatusInfo> Service::job(std::string_view id) {
  const std::lock_guard lock(impl_->mutex);
  BOOST_OUTCOME_TRY(job, impl_->find(id));
  return impl_->status_of(*job);
}

Reply<proto::StatusInfo> Service::dismiss(std::string_view id, const Caller& caller) {
  auto& impl = *impl_;
  const std::lock_guard changes(impl.changing);
  std::unique_lock lock(impl.mutex);
  BOOST_OUTCOME_TRY(job, impl.find(id));
  if (!may_change(job->record, caller)) return not_yours(job->record);
  if (job->waits_or_runs()) {
    lock.unlock();
    const auto changed = impl.change(*job, Impl::Need::written, [](proto::JobRecord& record) {
      record.set_state(job_state::dismissed);
      record.set_finished(time_text(system_clock::now()));
      record.set_message("was dismissed, and can go on");
    });
    if (!changed) return problem_of(changed.error());
    lock.lock();
    impl.waiting.erase(job->record.place());
    ++impl.since_start.dismissed;
    if (job->running) {
      job->running->ledger.stop();
    } else {
      impl.active.erase(job->record.id());
    }
    return impl.status_of(*job);
  }
  // The job's thread needs `changing` to let go; a job that was dismissed a moment ago still has its thread.
  if (job->running) return problem(409, "job " + std::string(id) + " is still stopping: try again", Errc::usage);
  auto last = impl.status_of(*job);
  last.set_message("was removed");
  lock.unlock();
  if (const auto gone = impl.forget(job); !gone) return problem_of(gone.error());
  return last;
}

Reply<proto::StatusInfo> Service::resume(std::string_view id, const Caller& caller) {
  auto& impl = *impl_;
  const std::lock_guard changes(impl.changing);
  std::unique_lock lock(impl.mutex);
  BOOST_OUTCOME_TRY(job, impl.find(id));
  if (!may_change(job->record, caller)) return not_yours(job->record);
  if (job->waits_or_runs()) return impl.status_of(*job);
  if (job->damaged) return problem(409, job->record.message(), Errc::corrupt);
  if (job->is(job_state::successful))
    return problem(409, "job " + std::string(id) + " is successful: there is nothing to resume", Errc::usage);
  auto record = job->record;
  if (const auto against = impl.conflict(record, caller)) return *against;
  const auto place = impl.next_place++;
  lock.unlock();
  const auto changed = impl.change(*job, Impl::Need::written, [&](proto::JobRecord& resumed) {
    resumed.set_state(job_state::accepted);
    resumed.set_place(place);
    resumed.set_deaths(0);
    resumed.clear_finished();
    resumed.clear_problem();
    resumed.set_message("waits to go on");
  });
  if (!changed) return problem_of(changed.error());
  lock.lock();
  impl.active.insert(record.id());
  impl.waiting[place] = record.id();
  impl.waiting_changed.notify_all();
  return impl.status_of(*job);
}

Reply<ServedFile> Service::log(std::string_view id) {
  {
    const std::lock_guard lock(impl_->mutex);
    BOOST_OUTCOME_TRYV(impl_->find(id));
  }
  const auto path = job_log_file(impl_->store.folder(std::string(id)));
  auto handle = open_handle(path, O_RDONLY | O_NOFOLLOW);
  if (!handle) return problem_of(handle.error());
  auto file = served(std::move(handle).value(), path, "text/plain; charset=utf-8", "");
  if (!file) return problem_of(file.error());
  return file.value();
}

Reply<ServedFile> Service::report(std::string_view id) {
  std::string name;
  {
    const std::lock_guard lock(impl_->mutex);
    BOOST_OUTCOME_TRY(job, impl_->find(id));
    if (!job->is(job_state::successful)) return result_not_ready(id, job->record.state());
    if (!job->record.inputs().has_triangulate())
      return problem(404, "job " + std::string(id) + " makes no report: it is no triangulation", Errc::usage);
    name = job->record.triangulation();
  }
  const auto own = impl_->results.made_by(name, std::string(id));
  if (!own) return problem_of(own.error());
  if (!own.value())
    return problem(410, "the triangulation of job " + std::string(id) + " was removed or replaced", Errc::usage);
  return impl_->results.file(name, report_file("").string());
}

Reply<std::string> Service::outcome(std::string_view id) {
  {
    const std::lock_guard lock(impl_->mutex);
    BOOST_OUTCOME_TRY(job, impl_->find(id));
    if (job->waits_or_runs()) return result_not_ready(id, job->record.state());
    if (job->is(job_state::failed)) return job->record.problem();
    if (job->is(job_state::dismissed))
      return problem(410, "job " + std::string(id) + " was dismissed; it can be resumed", Errc::interrupted);
  }
  const auto bytes = read_whole(job_outcome_file(impl_->store.folder(std::string(id))));
  if (!bytes) return problem_of(bytes.error());
  return std::string(as_text(bytes.value()));
}

namespace {

class Handle final : public Service::Subscription {
 public:
  Handle(Events& events, std::shared_ptr<Events::Listener> listener)
      : events_(events), listener_(std::move(listener)) {}
  ~Handle() override { events_.leave(listener_); }

 private:
  Events& events_;
  std::shared_ptr<Events::Listener> listener_;
};

}  // namespace

Reply<std::unique_ptr<Service::Subscription>> Service::subscribe(std::string_view id, std::uint64_t last,
                                                                 OnEvent on_event) {
  if (!id.empty()) {
    const std::lock_guard lock(impl_->mutex);
    BOOST_OUTCOME_TRYV(impl_->find(id));
  }
  const auto statuses = [&] {
    std::vector<proto::Event> events;
    const std::lock_guard lock(impl_->mutex);
    for (const auto& [name, job] : impl_->jobs) {
      if ((!id.empty() && name != id) || job->arriving) continue;
      auto& event = events.emplace_back();
      event.set_job_id(name);
      event.set_kind("status");
      *event.mutable_status() = impl_->status_of(*job);
      event.set_time(job->record.updated());
    }
    return events;
  };
  auto listener = impl_->events->listen(std::string(id), last, std::move(on_event), statuses);
  return std::unique_ptr<Subscription>(std::make_unique<Handle>(*impl_->events, std::move(listener)));
}

}  // namespace tessera
