#include "src/service/processes/table.h"

#include <algorithm>
#include <array>

#include "src/base/stopped.h"
#include "src/service/problem.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/rows.h"

namespace tessera::service {
namespace {

constexpr std::array<const Process*, 15> table{
    &triangulate_process, &region_process,  &verify_process, &export_process,  &dem_process,
    &contours_process,    &surface_process, &alpha_process,  &voronoi_process, &density_process,
    &volume_process,      &measure_process, &hag_process,    &update_process,  &info_process};

}  // namespace

std::span<const Process* const> all_processes() { return table; }

const Process* find_process(std::string_view name) {
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const Process* process) { return name == process->name; });
  return found == table.end() ? nullptr : *found;
}

const google::protobuf::FieldDescriptor& member_of(const Process& process) {
  return *proto::Inputs::descriptor()->FindFieldByName(process.name);
}

Reply<JobDone> do_work(const Workshop& shop, const JobWork& work) {
  const Ledger::Use use(&work.ledger);
  const Process* process = find_process(process_of(work.job.inputs()));
  if (process == nullptr)
    return problem(500, "the record of the job does not say which process it runs", Errc::corrupt);
  auto done = [&]() -> Reply<JobDone> {
    try {
      return process->run(shop, work);
    } catch (const Stopped& stopped) {
      return problem_of(error(Errc::interrupted, stopped.what()));
    }
  }();
  // An exceeded bound causes many different errors; the ledger's reason says what to change.
  if (const auto reason = work.ledger.reason(); reason && !done) return problem_of(*reason);
  return done;
}

}  // namespace tessera::service
