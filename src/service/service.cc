#include "src/service/service.h"

#include <algorithm>
#include <exception>
#include <new>
#include <set>

#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/whole_file.h"
#include "src/service/beneath.h"
#include "src/service/data_format.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"

namespace tessera {
namespace {

using std::chrono::steady_clock;
using std::chrono::system_clock;

constexpr std::chrono::milliseconds tick_time{500};
constexpr std::chrono::seconds retention_time{60};

Share share_of(const ServiceOptions& options) {
  const auto running = std::max(1U, options.limits.running);
  return {(options.threads + running - 1) / running, options.memory_bytes / running};
}

bool was_interrupted(const Reply<JobDone>& done) {
  return !done && done.error().cause() == static_cast<int>(Errc::interrupted);
}

// Whatever a job throws ends that job, and nothing else.
Reply<JobDone> guarded_work(const Workshop& shop, const JobWork& work) {
  try {
    return do_work(shop, work);
  } catch (const std::bad_alloc&) {
    return problem(422, "the system has no more memory to give", Errc::memory);
  } catch (const std::exception& thrown) {
    return problem(500, std::string("an internal error: ") + thrown.what(), Errc::internal);
  }
}

}  // namespace

Service::Impl::Impl(ServiceOptions given, FolderLock lock, Roots opened_roots, std::unique_ptr<Events> opened_events)
    : options(std::move(given)),
      share(share_of(options)),
      folder_lock(std::move(lock)),
      store(options.data),
      results(options.data),
      uploads(options.data, options.limits.upload_bytes),
      roots(std::move(opened_roots)),
      events(std::move(opened_events)),
      engine(options.threads, options.memory_bytes),
      shop{engine, roots, results, options.data, options.limits, share} {}

Service::Impl::~Impl() {
  {
    const std::lock_guard lock(mutex);
    ending = true;
    for (const auto& id : active)
      if (const auto& job = jobs.at(id); job->running) job->running->stop.request_stop();
  }
  waiting_changed.notify_all();
  tick_now.notify_all();
  for (auto& thread : threads) thread.join();
}

Status Service::Impl::load() {
  BOOST_OUTCOME_TRY(loaded, store.load());
  for (const auto& warning : loaded.warnings) tell(warning);
  std::set<std::string> known;
  for (auto& record : loaded.jobs) {
    known.insert(record.id());
    auto job = std::make_shared<Job>();
    job->record = std::move(record);
    auto& kept = job->record;
    next_place = std::max(next_place, kept.place() + 1);
    if (!kept.idempotency_key().empty()) by_key[{kept.caller(), kept.idempotency_key()}] = kept.id();
    if (job->waits_or_runs()) {
      if (job->is(job_state::running)) {
        kept.set_state(job_state::accepted);
        kept.set_message("waits to go on after a restart");
      }
      waiting[kept.place()] = kept.id();
      active.insert(kept.id());
    }
    jobs[kept.id()] = std::move(job);
  }
  forgotten = {loaded.forgotten.begin(), loaded.forgotten.end()};
  ids.seen(loaded.last_id);
  // Of jobs whose record cannot be read nothing is removed.
  FolderReader reader(jobs_folder(options.data));
  while (const char* name = reader.next()) known.insert(name);
  return results.open(known);
}

void Service::Impl::begin() {
  for (std::uint32_t i = 0; i < std::max(1U, options.limits.running); ++i) threads.emplace_back([this] { work(); });
  threads.emplace_back([this] { tick(); });
}

// The next job that no thread holds, now held by this one; null at the end.
std::shared_ptr<Job> Service::Impl::take() {
  std::unique_lock lock(mutex);
  while (true) {
    if (ending) return nullptr;
    for (const auto& [place, id] : waiting) {
      const auto& job = jobs.at(id);
      if (job->running) continue;  // dismissed and resumed: another thread has not let go yet
      job->running = std::make_shared<Running>();
      auto taken = job;
      waiting.erase(place);
      return taken;
    }
    waiting_changed.wait(lock);
  }
}

void Service::Impl::work() {
  while (const auto job = take()) {
    std::shared_ptr<Running> running;
    {
      const std::lock_guard lock(mutex);
      running = job->running;
    }
    if (!start(job, running)) {
      end(job, problem(410, "was dismissed", Errc::interrupted));
      continue;
    }
    proto::JobRecord record;
    {
      const std::lock_guard lock(mutex);
      record = job->record;
    }
    const JobWork work{record, running->progress, running->stop.get_token(),
                       [this, &record](const std::string& line) { log(record.id(), line); }, store.folder(record.id())};
    end(job, guarded_work(shop, work));
  }
}

// False when it has been dismissed since it was taken.
bool Service::Impl::start(const std::shared_ptr<Job>& job, const std::shared_ptr<Running>& running) {
  const std::lock_guard changes(changing);
  {
    const std::lock_guard lock(mutex);
    if (!job->is(job_state::accepted) || ending || running->stop.stop_requested()) return false;
  }
  const auto changed = change(*job, Need::done, [](proto::JobRecord& record) {
    record.set_state(job_state::running);
    record.set_starts(record.starts() + 1);
    record.set_started(time_text(system_clock::now()));
    record.clear_finished();
    record.clear_problem();
    record.set_message("runs");
  });
  static_cast<void>(changed);  // Need::done: it is written later if it could not be now
  return true;
}

// What the job has made gets its name. `replaced`: for Results::discard().
Reply<JobDone> Service::Impl::finish(const proto::JobRecord& job, Reply<JobDone> done,
                                     std::filesystem::path& replaced) {
  if (!done) return done;
  const auto published = [&]() -> Status {
    BOOST_OUTCOME_TRYV(store.write_outcome(job.id(), done.value().outcome));
    if (job.inputs().has_triangulate()) {
      BOOST_OUTCOME_TRY(old, results.publish(job.id(), job.triangulation(), job.inputs().triangulate().overwrite()));
      replaced = old;
    }
    if (job.inputs().has_export_()) {
      BOOST_OUTCOME_TRYV(results.publish_export(job.id(), job.triangulation()));
    }
    return success();
  }();
  if (!published) return problem_of(published.error());
  return done;
}

void Service::Impl::end(const std::shared_ptr<Job>& job, Reply<JobDone> done) {
  std::filesystem::path replaced;
  {
    const std::lock_guard changes(changing);
    proto::JobRecord record;
    bool stays = false;
    {
      const std::lock_guard lock(mutex);
      record = job->record;
      stays = ending && was_interrupted(done);  // "running" on disk: it goes on at the next start
    }
    if (record.state() == job_state::running && !stays) {
      done = finish(record, std::move(done), replaced);
      const auto changed = change(*job, Need::done, [&](proto::JobRecord& ended) {
        ended.set_finished(time_text(system_clock::now()));
        ended.set_state(done ? job_state::successful : job_state::failed);
        ended.set_message(done ? "is done" : done.error().detail());
        if (done && done.value().points > 0) ended.set_points(done.value().points);
        if (!done) *ended.mutable_problem() = done.error();
      });
      static_cast<void>(changed);  // as in start()
    }
    const std::lock_guard lock(mutex);
    if (record.state() == job_state::running && !stays) {
      ++(done ? since_start.successful : since_start.failed);
      if (done) since_start.points += done.value().points;
      if (done)
        for (const auto& [phase, seconds] : done.value().seconds) phase_seconds[phase] += seconds;
    }
    job->running.reset();
    if (!job->waits_or_runs()) active.erase(record.id());
  }
  let_go.notify_all();
  waiting_changed.notify_all();
  if (const auto discarded = Results::discard(replaced); !discarded) tell(discarded.error().where);
}

void Service::Impl::tick() {
  auto retention = steady_clock::now();
  std::unique_lock lock(mutex);
  while (!ending) {
    ticked = steady_clock::now();
    lock.unlock();
    tell_progress();
    write_again();
    if (options.retention_s > 0 && steady_clock::now() >= retention) {
      forget_old();
      retention = steady_clock::now() + retention_time;
    }
    lock.lock();
    if (!ending) tick_now.wait_for(lock, tick_time);
  }
}

void Service::Impl::tell_progress() {
  const std::lock_guard lock(mutex);
  for (const auto& id : active) {
    Job& job = *jobs.at(id);
    if (!job.running || !job.is(job_state::running)) continue;
    proto::Event event;
    event.set_job_id(id);
    event.set_kind("progress");
    *event.mutable_status() = status_of(job);
    // Only what has changed; the time that is left always does.
    proto::StatusInfo compared = event.status();
    compared.clear_eta_s();
    compared.mutable_figures()->clear_elapsed_s();
    auto text = compared.SerializeAsString();
    if (text == job.told) continue;
    job.told = std::move(text);
    event.set_time(time_text(system_clock::now()));
    events->tell(std::move(event));
  }
}

void Service::Impl::write_again() {
  const std::lock_guard changes(changing);
  std::vector<std::shared_ptr<Job>> late;
  {
    const std::lock_guard lock(mutex);
    for (const auto& id : unwritten) late.push_back(jobs.at(id));
  }
  for (const auto& job : late) {
    if (!store.replace(job->record)) return;  // the next time
    const std::lock_guard lock(mutex);
    unwritten.erase(job->record.id());
  }
}

void Service::Impl::forget_old() {
  const auto before = system_clock::now() - std::chrono::seconds(options.retention_s);
  const std::lock_guard changes(changing);
  std::vector<std::shared_ptr<Job>> old;
  {
    const std::lock_guard lock(mutex);
    for (const auto& [id, job] : jobs) {
      if (job->waits_or_runs() || job->running || unwritten.contains(id)) continue;
      if (time_of(job->record.finished()) < before) old.push_back(job);
    }
  }
  for (const auto& job : old)
    if (const auto gone = forget(job); !gone) tell(gone.error().where);
}

Result<std::unique_ptr<Service>> Service::open(ServiceOptions options) {
  const auto refuse = [](const std::string& what) { return error(Errc::usage, what); };
  if (options.data.empty()) return refuse("no data folder is given");
  if (options.limits.running < 1) return refuse("at least one job must be allowed to run");
  if (options.threads < 1) return refuse("at least one thread is needed");
  if (options.memory_bytes / options.limits.running < (std::uint64_t{64} << 20))
    return refuse("a job would have less than 64 MiB of memory: give more, or let fewer run at once");
  BOOST_OUTCOME_TRYV(make_directories(options.data));
  options.data = std::filesystem::absolute(options.data).lexically_normal();
  BOOST_OUTCOME_TRY(lock, FolderLock::take(options.data));
  BOOST_OUTCOME_TRYV(check_data_format(options.data));
  if (options.uploads) {
    BOOST_OUTCOME_TRYV(make_directories(uploads_folder(options.data)));
  }
  BOOST_OUTCOME_TRY(roots, Roots::open(options.roots, options.uploads ? uploads_folder(options.data) : ""));
  BOOST_OUTCOME_TRY(events, Events::open(event_numbers_file(options.data)));
  auto impl = std::make_unique<Impl>(std::move(options), std::move(lock), std::move(roots), std::move(events));
  BOOST_OUTCOME_TRYV(impl->load());
  if (impl->options.uploads) {
    BOOST_OUTCOME_TRYV(impl->uploads.open());
  }
  impl->begin();
  return std::unique_ptr<Service>(new Service(std::move(impl)));
}

Service::Service(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Service::~Service() = default;

}  // namespace tessera
