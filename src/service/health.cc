#include "src/service/health.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/free_space.h"
#include "src/job/report/human.h"
#include "src/service/problem.h"

namespace tessera::service {

ServiceFigures ServiceHealth::figures() const {
  // Before the lock, because this asks the cluster's coordinator.
  std::vector<std::pair<std::string, std::uint64_t>> nodes{{"joining", 0}, {"free", 1}};
  std::uint64_t lost = 0;
  if (of_.certificate_end_s) {
    const auto all = of_.engine.nodes();
    const auto count =
        static_cast<std::uint64_t>(std::count_if(all.begin(), all.end(), [](const NodeState& n) { return n.free; }));
    nodes = {{"joining", all.size() - count}, {"free", count}};
    lost = of_.engine.nodes_lost();
  }
  const std::lock_guard lock(of_.jobs.mutex);
  ServiceFigures figures = of_.jobs.since_start;
  figures.nodes = std::move(nodes);
  figures.nodes_lost = lost;
  figures.certificate_end_s = static_cast<double>(of_.certificate_end_s.value_or(0));
  for (const auto& id : of_.jobs.active) {
    const Job& job = *of_.jobs.jobs.at(id);
    if (job.is(job_state::accepted)) ++figures.accepted;
    if (job.is(job_state::running)) ++figures.running;
    if (!job.running) continue;
    const auto& progress = job.running->progress;
    figures.bytes_between += progress.bytes_between;
    figures.credit_waits += progress.credit_waits;
    // In this order: updates that are sent between the two reads count as waiting, and the difference is never
    // negative.
    const std::uint64_t processed = progress.updates_processed;
    figures.updates_waiting += std::max(processed, progress.updates_sent.load()) - processed;
  }
  figures.memory_used_bytes = of_.jobs.memory_used();
  figures.memory_budget_bytes = of_.memory_bytes;
  figures.disk_free_bytes = free_bytes(of_.data);
  figures.phase_seconds = {of_.jobs.phase_seconds.begin(), of_.jobs.phase_seconds.end()};
  figures.open_results = of_.questions.open_results();
  figures.subscribers = of_.jobs.events.listeners();
  return figures;
}

std::optional<std::string> ServiceHealth::lost() const {
  const auto held = of_.data_folder.heard();
  return held ? std::nullopt : std::optional(held.error().where);
}

std::optional<std::string> ServiceHealth::unready() const {
  constexpr std::uint64_t free_min = std::uint64_t{16} << 20;  // records and logs of many jobs
  constexpr std::chrono::seconds silence_max{30};
  if (const auto held = of_.data_folder.still_ours(); !held) return held.error().where;
  const auto writable = nameless_file(of_.data);
  if (!writable) return problem_of(writable.error()).detail();
  if (const auto free = free_bytes(of_.data); free < free_min)
    return of_.data.string() + ": only " + human_bytes(free) +
           " are free on its disk, too little for the records of jobs";
  {
    const std::lock_guard lock(of_.jobs.mutex);
    if (!of_.jobs.unwritten.empty())
      return "the state of " + grouped(of_.jobs.unwritten.size()) + " jobs could not be written to " +
             of_.data.string();
  }
  if (of_.upkeep.silence() > silence_max)
    return "the thread that watches the jobs has not answered for more than 30 seconds";
  return std::nullopt;
}

}  // namespace tessera::service
