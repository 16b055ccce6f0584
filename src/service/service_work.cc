// The threads that work on jobs: which job is next, and how it ends.
#include <chrono>
#include <exception>
#include <new>
#include <utility>
#include <vector>

#include "src/service/processes/costs.h"
#include "src/service/jobs/deaths.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"

namespace tessera {
namespace {

using std::chrono::system_clock;

bool was_interrupted(const Reply<JobDone>& done) {
  return !done && done.error().cause() == static_cast<int>(Errc::interrupted);
}

// An exception of a job ends that job, and nothing else.
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

// The next job that no thread holds; null when none may run beside the running ones.
std::shared_ptr<Job> Service::Impl::next() const {
  if (held_alone) return nullptr;
  for (const auto& [place, id] : waiting) {
    const auto& job = jobs.at(id);
    if (job->running) continue;  // dismissed and resumed: another thread has not let go yet
    // No later job overtakes it.
    return job->record.deaths() > 0 && held > 0 ? nullptr : job;
  }
  return nullptr;
}

// The next job, which this thread now holds; null at the end.
std::shared_ptr<Job> Service::Impl::take() {
  std::unique_lock lock(mutex);
  while (true) {
    if (ending) return nullptr;
    auto job = next();
    // Nodes that still work on this job may be about to join. While the job waits for them, it counts as not begun, so
    // that a death of this process is not counted against it.
    if (job && job->record.starts() > 0 && engine->gathering()) {
      waiting_changed.wait_for(lock, std::chrono::milliseconds(100));
      continue;
    }
    if (job) {
      job->running = std::make_shared<Running>(bounds_of_job(options.limits, options.data));
      waiting.erase(job->record.place());
      ++held;
      held_alone = job->record.deaths() > 0;
      return job;
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
    const auto tell_log = [this, &record](const std::string& line) {
      const Ledger::Use none(nullptr);  // a job that has used up its bound can still write why
      log(record.id(), line);
    };
    const JobWork work{record, running->progress, running->ledger, tell_log, store.folder(record.id())};
    end(job, guarded_work(shop, work));
  }
}

// Returns false when the job was dismissed after it was taken.
bool Service::Impl::start(const std::shared_ptr<Job>& job, const std::shared_ptr<Running>& running) {
  const std::lock_guard changes(changing);
  {
    const std::lock_guard lock(mutex);
    if (!job->is(job_state::accepted) || ending || running->ledger.token().stop_requested()) return false;
  }
  const auto changed = change(*job, Need::done, [](proto::JobRecord& record) {
    record.set_state(job_state::running);
    record.set_starts(record.starts() + 1);
    record.set_started(time_text(system_clock::now()));
    record.clear_finished();
    record.clear_problem();
    record.clear_message();  // the state says it
  });
  static_cast<void>(changed);  // Need::done: if it cannot be written now, it is written later
  return true;
}

// Tiles that nodes have triangulated outlive the coordinator's process. Without nodes only stored tiles do.
void Service::Impl::forgive_deaths() {
  const std::lock_guard changes(changing);
  std::vector<std::pair<std::shared_ptr<Job>, std::uint64_t>> got_on;
  {
    const std::lock_guard lock(mutex);
    for (const auto& id : active) {
      const auto& job = jobs.at(id);
      if (!job->running || !job->is(job_state::running)) continue;
      const Progress& progress = job->running->progress;
      const std::uint64_t done = progress.tiles_stored + (options.cluster ? progress.tiles_triangulated.load() : 0);
      if (gets_on(job->record, done, progress.tiles_total)) got_on.emplace_back(job, done);
    }
  }
  for (const auto& [job, done] : got_on) {
    const auto changed = change(*job, Need::done, [done = done](proto::JobRecord& record) {
      record.set_deaths(0);
      record.set_reached(done);
    });
    static_cast<void>(changed);  // as in start()
  }
}

// Gives the job's output its name. `replaced` gets a folder for Results::discard().
Reply<JobDone> Service::Impl::finish(const proto::JobRecord& job, Reply<JobDone> done,
                                     std::filesystem::path& replaced) {
  if (!done) return done;
  const auto published = [&]() -> Status {
    BOOST_OUTCOME_TRYV(store.write_outcome(job.id(), done.value().outcome));
    if (makes_result(job.inputs())) {
      BOOST_OUTCOME_TRY(old, results.publish(job.id(), job.triangulation(), overwrites(job.inputs())));
      replaced = old;
      if (!replaced.empty()) questions.close(job.triangulation());
    }
    if (export_output(job.inputs())) {
      BOOST_OUTCOME_TRYV(results.publish_export(job));
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
      stays = ending && was_interrupted(done);
    }
    if (record.state() == job_state::running && stays) {
      const auto changed = change(*job, Need::done, [](proto::JobRecord& waits) {
        waits.set_deaths(0);
        waits.set_state(job_state::accepted);
        waits.set_message("waits to go on after a restart");
      });
      static_cast<void>(changed);  // as in start()
    }
    if (record.state() == job_state::running && !stays) {
      done = finish(record, std::move(done), replaced);
      if (!done) done = in_callers_words(std::move(done).error());
      const auto changed = change(*job, Need::done, [&](proto::JobRecord& ended) {
        ended.set_deaths(0);
        ended.set_finished(time_text(system_clock::now()));
        ended.set_state(done ? job_state::successful : job_state::failed);
        if (done) drop_inputs(ended);
        ended.set_message(done ? "" : done.error().detail());
        if (done && done.value().points > 0) ended.set_points(done.value().points);
        ended.set_nodes_lost(job->running->progress.nodes_lost);
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
    since_start.bytes_between += job->running->progress.bytes_between;
    since_start.credit_waits += job->running->progress.credit_waits;
    job->running.reset();
    one_has_ended = true;
    std::string().swap(job->told);  // frees memory: there are many ended jobs
    --held;
    held_alone = false;
    if (!job->waits_or_runs()) active.erase(record.id());
  }
  waiting_changed.notify_all();
  if (const auto discarded = Results::discard(replaced); !discarded) tell(discarded.error().where);
}

proto::Problem Service::Impl::in_callers_words(proto::Problem problem) const {
  problem.set_detail(roots.named(problem.detail()));
  if (problem.has_marked()) problem.set_marked(roots.named(problem.marked()));
  return problem;
}

}  // namespace tessera
