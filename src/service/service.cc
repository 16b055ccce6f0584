#include "src/service/service.h"
#include "src/job/engine_steps.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "actors/cluster/seat.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/thread_name.h"
#include "src/service/beneath.h"
#include "src/service/data_folder.h"
#include "src/service/data_format.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"

namespace tessera {
namespace {

using std::chrono::steady_clock;
using std::chrono::system_clock;

constexpr std::chrono::milliseconds tick_time{500};
constexpr std::chrono::seconds retention_time{60};
constexpr std::chrono::hours part_time{24};  // for partial uploads: nobody continues one that is this old

JobShare share_of(const ServiceOptions& options) {
  const auto running = std::max(1U, options.limits.running);
  return {(options.threads + running - 1) / running, options.memory_bytes / running};
}

// Questions use memory in addition to that of jobs, which is most of the machine's: an eighth of it.
QuestionLimits limits_of_questions(const ServiceOptions& options) {
  return {.memory_bytes = options.memory_bytes / 8, .threads = std::max(1U, options.threads / 2)};
}

Result<std::unique_ptr<Engine>> open_engine(const ServiceOptions& options) {
  if (!options.cluster) return std::make_unique<Engine>(options.threads, options.memory_bytes, kinds_of_stages());
  auto cluster = *options.cluster;
  cluster.jobs_at_once = options.limits.running;
  BOOST_OUTCOME_TRY(identity, data_identity(options.data));
  cluster.shared = identity;
  cluster.data = options.data;
  return Engine::join(options.threads, options.memory_bytes, std::make_unique<Seat>(std::move(cluster)),
                      kinds_of_stages());
}

}  // namespace

Service::Impl::Impl(ServiceOptions given, std::unique_ptr<DataFolder> held, Roots opened_roots,
                    std::unique_ptr<Events> opened_events, std::unique_ptr<Engine> opened_engine)
    : options(std::move(given)),
      share(share_of(options)),
      data_folder(std::move(held)),
      store(options.data, data_folder->desk()),
      results(options.data, data_folder->desk_of_results()),
      questions(results, options.data, limits_of_questions(options)),
      maps(results),
      uploads(options.data, {.bytes = options.limits.upload_bytes, .reserve_bytes = options.limits.reserve_bytes},
              data_folder->desk_of_uploads()),
      clouds(options.memory_bytes / 8),
      roots(std::move(opened_roots)),
      events(std::move(opened_events)),
      engine(std::move(opened_engine)),
      shop{*engine, roots, results, options.data, options.limits, share, clouds, options.data_lease} {}

Service::Impl::~Impl() {
  {
    const std::lock_guard lock(mutex);
    ending = true;
    for (const auto& id : active)
      if (const auto& job = jobs.at(id); job->running) job->running->ledger.stop();
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
  // Nothing is removed of jobs whose record cannot be read.
  FolderReader reader(jobs_folder(options.data));
  while (const char* name = reader.next()) known.insert(name);
  if (reader.error()) return io_error(jobs_folder(options.data), "cannot be read", reader.error().value());
  return results.open(known);
}

// An accepted job must not be reported as missing.
void Service::Impl::add_damaged(const std::string& id, const std::string& why) {
  tell(why);
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
void Service::Impl::recover(Job& job) {
  const auto deaths = job.record.deaths() + 1;
  const auto waits = [&](proto::JobRecord& record) {
    record.set_deaths(deaths);
    record.set_state(job_state::accepted);
    record.set_message("waits to go on after a restart");
  };
  const auto fails = [&](proto::JobRecord& record) {
    *record.mutable_problem() =
        problem(500,
                "the daemon died " + std::to_string(deaths) +
                    " times one after the other while this job ran; it is not begun again unless it is resumed",
                Errc::internal);
    record.set_deaths(0);
    record.set_finished(time_text(system_clock::now()));
    record.set_state(job_state::failed);
    record.set_message(record.problem().detail());
  };
  const auto changed = deaths < options.limits.deaths ? change(job, Need::done, waits) : change(job, Need::done, fails);
  static_cast<void>(changed);  // Need::done: if it cannot be written now, it is written later
}

void Service::Impl::begin() {
  for (std::uint32_t i = 0; i < std::max(1U, options.limits.running); ++i) {
    threads.emplace_back([this] {
      name_thread("job");
      work();
    });
  }
  threads.emplace_back([this] {
    name_thread("tick");
    tick();
  });
}

void Service::Impl::tick() {
  auto retention = steady_clock::now();
  std::unique_lock lock(mutex);
  while (!ending) {
    ticked = steady_clock::now();
    lock.unlock();
    tell_progress();
    forgive_deaths();
    write_again();
    forget_beyond();
    if (steady_clock::now() >= retention) {
      if (options.retention_s > 0) forget_old();
      if (options.uploads)
        for (const auto& line : uploads.expire(system_clock::now() - part_time)) tell(line);
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
    // Only changes are sent. The remaining and elapsed times, which always change, are not compared.
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
    if (!store.replace(job->record)) return;  // tried again the next time
    const std::lock_guard lock(mutex);
    unwritten.erase(job->record.id());
  }
}

void Service::Impl::forget_old() {
  const auto before = system_clock::now() - std::chrono::seconds(options.retention_s);
  const std::lock_guard changes(changing);
  for (const auto& job : ended_jobs())
    if (time_of(job->record.finished()) < before) forget_or_tell(job);
}

void Service::Impl::forget_beyond() {
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
      if (++count > options.limits.ended_of_a_caller || bytes > inputs_of_caller_bytes_max) forget_or_tell(job);
    }
  }
}

std::vector<std::shared_ptr<Job>> Service::Impl::ended_jobs() const {
  std::vector<std::shared_ptr<Job>> ended;
  const std::lock_guard lock(mutex);
  for (const auto& [id, job] : jobs)
    if (!job->waits_or_runs() && !job->running && !job->damaged && !unwritten.contains(id)) ended.push_back(job);
  return ended;
}

void Service::Impl::forget_or_tell(const std::shared_ptr<Job>& job) {
  if (const auto gone = forget(job); !gone) tell(gone.error().where);
}

Result<std::unique_ptr<Service>> Service::open(ServiceOptions options) {
  const auto refuse = [](const std::string& what) { return error(Errc::usage, what); };
  if (options.data.empty()) return refuse("no data folder is given");
  if (options.limits.running < 1) return refuse("at least one job must be allowed to run");
  if (options.threads < 1) return refuse("at least one thread is needed");
  if (options.memory_bytes / options.limits.running < (std::uint64_t{64} << 20))
    return refuse("a job would have less than 64 MiB of memory: give more, or let fewer run at once");
  options.data = std::filesystem::absolute(options.data).lexically_normal();
  BOOST_OUTCOME_TRYV(check_apart(options.data, options.roots));
  BOOST_OUTCOME_TRY(held, DataFolder::hold(options));
  BOOST_OUTCOME_TRY(roots, Roots::open(options.roots, options.uploads ? uploads_folder(options.data) : ""));
  BOOST_OUTCOME_TRY(events, Events::open(event_numbers_file(options.data), held->desk(), options.log));
  BOOST_OUTCOME_TRY(engine, open_engine(options));
  auto impl = std::make_unique<Impl>(std::move(options), std::move(held), std::move(roots), std::move(events),
                                     std::move(engine));
  BOOST_OUTCOME_TRYV(impl->load());
  BOOST_OUTCOME_TRYV(impl->questions.open());
  if (impl->options.uploads) {
    BOOST_OUTCOME_TRYV(impl->uploads.open());
  }
  impl->begin();
  return std::unique_ptr<Service>(new Service(std::move(impl)));
}

Service::Service(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Service::~Service() = default;

}  // namespace tessera
