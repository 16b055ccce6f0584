#include "src/service/jobs/job_status.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "src/job/report/progress_line.h"
#include "src/service/processes/kinds.h"

namespace tessera::service {
namespace {

using std::chrono::steady_clock;

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

}  // namespace

proto::StatusInfo status_of(const Job& job) {
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

}  // namespace tessera::service
