// Lists what can be downloaded or chosen: the exports of results, and inputs.
#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/printable.h"
#include "src/input/cloud/cloud.h"
#include "src/input/format.h"
#include "src/service/deadline.h"
#include "src/service/processes/kinds.h"
#include "src/service/results/owners.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"

namespace tessera {
namespace fs = std::filesystem;
namespace {

using std::chrono::system_clock;

constexpr std::uint32_t files_counted = 10'000;  // of an export that is a folder
constexpr std::chrono::seconds headers_time{5};  // for reading headers of inputs; further entries come without

std::string time_of_file(std::int64_t seconds, std::int64_t nanoseconds = 0) {
  return time_text(system_clock::from_time_t(seconds) + std::chrono::milliseconds(nanoseconds / 1'000'000));
}

// Adds up a file or a folder, up to a number of files. Files that vanish meanwhile are left out.
Status measure(const fs::path& path, proto::ExportInfo& into) {
  BOOST_OUTCOME_TRY(status, look_at(path, FollowLinks::no));
  if (!status || into.files() >= files_counted) return success();
  if (S_ISREG(status->st_mode)) {
    into.set_files(into.files() + 1);
    into.set_bytes(into.bytes() + static_cast<std::uint64_t>(status->st_size));
  }
  if (!S_ISDIR(status->st_mode)) return success();
  BOOST_OUTCOME_TRY(names, sorted_names(path));
  for (const auto& name : names) {
    BOOST_OUTCOME_TRYV(measure(path / name, into));
  }
  return success();
}

// Returns false for an export that cannot be read or has just vanished.
Result<bool> look_at_export(const fs::path& path, proto::ExportInfo& into) {
  BOOST_OUTCOME_TRY(status, look_at(path, FollowLinks::no));
  if (!status || (!S_ISREG(status->st_mode) && !S_ISDIR(status->st_mode))) return false;
  into.set_created(time_of_file(status->st_mtim.tv_sec, status->st_mtim.tv_nsec));
  BOOST_OUTCOME_TRYV(measure(path, into));
  if (into.files() >= files_counted) into.set_bytes(0);
  BOOST_OUTCOME_TRY(owner, owner_of(path));
  into.set_submitter(owner);
  return true;
}

// Reads the header of a file. `real` is the path of the file, below one of the roots.
void look_into(const Roots& roots, const fs::path& real, const std::stop_token& stop, proto::InputInfo& into) {
  const auto cloud = Cloud::open({real.string()}, {.dimension = 0}, stop);
  if (!cloud) {
    into.set_note(printable(roots.named(cloud.error().where)));  // callers need not know where the roots are
    return;
  }
  for (const FileInfo& file : cloud.value().files()) {
    into.set_format(file.format);
    if (file.points) into.set_points(*file.points);
    if (file.bounds && !file.bounds->empty())
      for (const Point& corner : {file.bounds->lo, file.bounds->hi})
        for (int axis = 0; axis < file.dimension; ++axis) into.add_bounds(corner[axis]);
  }
  if (!cloud.value().crs().empty()) into.set_crs(printable(crs_title(cloud.value().crs())));
}

}  // namespace

Reply<proto::ExportList> Service::exports(std::string_view name, std::uint32_t limit, std::string_view after) {
  auto& impl = *impl_;
  const auto there = impl.results.exists(name);
  if (!there) return problem_of(there.error());
  if (!there.value()) return problem(404, "there is no triangulation '" + std::string(name) + "'");
  const fs::path folder = exports_folder(impl.results.folder(name));
  std::vector<std::string> names;
  const auto any = is_folder(folder, FollowLinks::no);
  if (!any) return problem_of(any.error());
  if (any.value()) {
    auto all = sorted_names(folder);
    if (!all) return problem_of(all.error());
    names = std::move(all).value();
    // Files that are being made or removed have names that callers cannot give.
    std::erase_if(names, [](const std::string& each) { return !check_name(each) || is_temporary_name(each); });
  }
  std::map<std::string, std::pair<std::string, std::string>> makers;  // by export: the job that made it last, and how
  {
    const std::lock_guard lock(impl.mutex);
    for (const auto& [id, job] : impl.jobs) {
      const auto output = export_output(job->record.inputs());
      if (output && job->record.triangulation() == name && job->is(job_state::successful))
        makers[*output] = {id, process_of(job->record.inputs())};
    }
  }
  proto::ExportList list;
  list.set_number_matched(names.size());
  for (auto each = std::upper_bound(names.begin(), names.end(), after); each != names.end(); ++each) {
    if (static_cast<std::uint32_t>(list.exports_size()) >= limit) break;
    proto::ExportInfo info;
    const auto looked = look_at_export(folder / *each, info);
    if (!looked) return problem_of(looked.error());
    if (!looked.value()) continue;
    info.set_name(*each);
    if (const auto maker = makers.find(*each); maker != makers.end()) {
      info.set_job_id(maker->second.first);
      info.set_process_id(maker->second.second);
    }
    *list.add_exports() = std::move(info);
  }
  return list;
}

Reply<proto::InputList> Service::inputs(std::string_view folder, std::uint32_t limit, std::string_view after,
                                        const Caller& caller) {
  if (caller.role < Role::submit) return problem(403, "to be told of inputs takes the role submit", Errc::usage);
  WhileAnyoneWaits waited(caller.stop);
  auto entries = impl_->roots.list(std::string(folder));
  if (!entries) return problem_of_inputs(waited.ledger().reason().value_or(entries.error()));
  // A name that JSON cannot hold cannot be an input of a job.
  std::erase_if(entries.value(), [](const RootEntry& each) { return printable(each.name) != each.name; });
  proto::InputList list;
  list.set_folder(std::string(folder));
  list.set_number_matched(entries.value().size());
  const auto begun = std::chrono::steady_clock::now();
  for (const RootEntry& entry : entries.value()) {
    if (entry.name <= after) continue;
    if (static_cast<std::uint32_t>(list.inputs_size()) >= limit) break;
    proto::InputInfo& info = *list.add_inputs();
    info.set_name(entry.name);
    info.set_modified(time_of_file(entry.found.modified_s));
    info.set_folder(entry.found.kind == KindBeneath::folder);
    if (info.folder()) continue;
    info.set_bytes(entry.found.bytes);
    const fs::path unpacked = without_packing(entry.name);
    info.set_format(unpacked.extension().string().substr(1));
    // Packed files would have to be unpacked.
    if (unpacked != fs::path(entry.name) || std::chrono::steady_clock::now() - begun > headers_time) continue;
    look_into(impl_->roots, entry.found.real, waited.ledger().token(), info);
    if (const auto over = waited.ledger().reason()) return problem_of_inputs(*over);
  }
  return list;
}

}  // namespace tessera
