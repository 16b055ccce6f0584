#include "src/service/jobs/workers.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "src/base/thread_name.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/problem.h"

namespace tessera::service {
namespace {

using std::chrono::system_clock;

bool was_interrupted(const Reply<JobDone>& done) {
  return !done && done.error().cause() == static_cast<int>(Errc::interrupted);
}

}  // namespace

Workers::Workers(JobTable& table, WorkersHooks hooks, std::uint32_t count) : table_(table), hooks_(std::move(hooks)) {
  for (std::uint32_t i = 0; i < std::max(1U, count); ++i) {
    threads_.emplace_back([this] {
      name_thread("job");
      run();
    });
  }
}

Workers::~Workers() {
  {
    const std::lock_guard lock(table_.mutex);
    ending_ = true;
    for (const auto& id : table_.active)
      if (const auto& job = table_.jobs.at(id); job->running) job->running->ledger.stop();
  }
  table_.waiting_changed.notify_all();
  for (auto& thread : threads_) thread.join();
}

// The next job that no thread holds; null when none may run beside the running ones.
std::shared_ptr<Job> Workers::next() const {
  if (held_alone_) return nullptr;
  for (const auto& [place, id] : table_.waiting) {
    const auto& job = table_.jobs.at(id);
    if (job->running) continue;  // dismissed and resumed: another thread has not let go yet
    // No later job overtakes it.
    return job->record.deaths() > 0 && held_ > 0 ? nullptr : job;
  }
  return nullptr;
}

// The next job, which this thread now holds; null at the end.
std::shared_ptr<Job> Workers::take() {
  std::unique_lock lock(table_.mutex);
  while (true) {
    if (ending_) return nullptr;
    auto job = next();
    // Nodes that still work on this job may be about to join. While the job waits for them, it counts as not begun, so
    // that a death of this process is not counted against it.
    if (job && job->record.starts() > 0 && hooks_.gathering && hooks_.gathering()) {
      table_.waiting_changed.wait_for(lock, std::chrono::milliseconds(100));
      continue;
    }
    if (job) {
      job->running = std::make_shared<Running>(hooks_.bounds ? hooks_.bounds() : Ledger::Bounds{});
      table_.waiting.erase(job->record.place());
      ++held_;
      held_alone_ = job->record.deaths() > 0;
      return job;
    }
    table_.waiting_changed.wait(lock);
  }
}

void Workers::run() {
  while (const auto job = take()) {
    std::shared_ptr<Running> running;
    {
      const std::lock_guard lock(table_.mutex);
      running = job->running;
    }
    if (!start(job, running)) {
      end(job, problem(410, "was dismissed", Errc::interrupted));
      continue;
    }
    proto::JobRecord record;
    {
      const std::lock_guard lock(table_.mutex);
      record = job->record;
    }
    const auto tell_log = [this, &record](const std::string& line) {
      const Ledger::Use none(nullptr);  // a job that has used up its bound can still write why
      table_.log(record.id(), line);
    };
    const JobWork work{record, running->progress, running->ledger, tell_log, table_.store.folder(record.id())};
    end(job, guarded(work));
  }
}

Reply<JobDone> Workers::guarded(const JobWork& work) const {
  try {
    return hooks_.work(work);
  } catch (const std::bad_alloc&) {
    return problem(
        422, "the operating system gave the job no more memory: let fewer jobs run at once, or give them less memory",
        Errc::memory);
  } catch (const std::exception& thrown) {
    return problem(500, std::string("an internal error: ") + thrown.what(), Errc::internal);
  }
}

// Returns false when the job was dismissed after it was taken.
bool Workers::start(const std::shared_ptr<Job>& job, const std::shared_ptr<Running>& running) {
  const std::lock_guard changes(table_.changing);
  {
    const std::lock_guard lock(table_.mutex);
    if (!job->is(job_state::accepted) || ending_ || running->ledger.token().stop_requested()) return false;
  }
  const auto changed = table_.change(*job, JobTable::Need::done, [](proto::JobRecord& record) {
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

// `replaced` gets the folder of what the job's output has replaced.
Reply<JobDone> Workers::finish(const proto::JobRecord& job, Reply<JobDone> done, std::filesystem::path& replaced) {
  if (!done) return done;
  const auto kept = table_.store.write_outcome(job.id(), done.value().outcome);
  if (!kept) return problem_of(kept.error());
  if (!hooks_.publish) return done;
  auto published = hooks_.publish(job);
  if (!published) return std::move(published).error();
  replaced = std::move(published).value();
  return done;
}

void Workers::end(const std::shared_ptr<Job>& job, Reply<JobDone> done) {
  std::filesystem::path replaced;
  {
    const std::lock_guard changes(table_.changing);
    proto::JobRecord record;
    bool stays = false;
    {
      const std::lock_guard lock(table_.mutex);
      record = job->record;
      stays = ending_ && was_interrupted(done);
    }
    if (record.state() == job_state::running && stays) {
      const auto changed = table_.change(*job, JobTable::Need::done, [](proto::JobRecord& waits) {
        waits.set_deaths(0);
        waits.set_state(job_state::accepted);
        waits.set_message("waits to go on after a restart of the daemon");
      });
      static_cast<void>(changed);  // as in start()
    }
    if (record.state() == job_state::running && !stays) {
      done = finish(record, std::move(done), replaced);
      if (!done) done = table_.in_callers_words(std::move(done).error());
      const auto changed = table_.change(*job, JobTable::Need::done, [&](proto::JobRecord& ended) {
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
    const std::lock_guard lock(table_.mutex);
    if (record.state() == job_state::running && !stays) {
      ++(done ? table_.since_start.successful : table_.since_start.failed);
      if (done) table_.since_start.points += done.value().points;
      if (done)
        for (const auto& [phase, seconds] : done.value().seconds) table_.phase_seconds[phase] += seconds;
    }
    table_.since_start.bytes_between += job->running->progress.bytes_between;
    table_.since_start.credit_waits += job->running->progress.credit_waits;
    job->running.reset();
    table_.one_has_ended = true;
    std::string().swap(job->told);  // frees memory: there are many ended jobs
    --held_;
    held_alone_ = false;
    if (!job->waits_or_runs()) table_.active.erase(record.id());
  }
  table_.waiting_changed.notify_all();
  if (!hooks_.discard || replaced.empty()) return;
  if (const auto discarded = hooks_.discard(replaced); !discarded) table_.warn(discarded.error().where);
}

}  // namespace tessera::service
