#include "src/service/results/results.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "src/base/crs/survey_system.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/json/json_text.h"
#include "src/job/describe_versions.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"
#include "src/service/results/owners.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

// The names directly below exports of the files that an export job has written beside its output.
std::set<std::string> exports_in(const std::string& outcome) {
  std::set<std::string> names;
  const auto json = parse_json(outcome);
  if (!json.is_object() || !json.contains("written") || !json["written"].is_array()) return names;
  for (const auto& entry : json["written"]) {
    if (!entry.is_object() || !entry.contains("path") || !entry["path"].is_string()) continue;
    const auto inside = std::filesystem::path(entry["path"].get<std::string>()).lexically_relative(exports_folder(""));
    if (!inside.empty() && check_name(inside.begin()->string())) names.insert(*inside.begin());
  }
  return names;
}

constexpr std::uint32_t files_counted = 10'000;  // of an export that is a folder

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

}  // namespace

Reply<proto::TriangulationList> Results::list(std::uint32_t limit, std::string_view after) {
  const auto found = folders_.names();
  if (!found) return problem_of(found.error());
  const auto& names = found.value();
  proto::TriangulationList list;
  list.set_number_matched(names.size());
  for (auto name = std::upper_bound(names.begin(), names.end(), after); name != names.end(); ++name) {
    if (static_cast<std::uint32_t>(list.triangulations_size()) >= limit) break;
    auto info = folders_.info(*name);
    if (!info) {  // damaged or gone meanwhile: it must not hide the others
      table_.warn("triangulation '" + *name + "': " + info.error().detail());
      list.add_triangulations()->set_name(*name);
      continue;
    }
    *list.add_triangulations() = std::move(info).value();
  }
  return list;
}

Reply<proto::TriangulationInfo> Results::info(std::string_view name) {
  auto info = folders_.info(name);
  if (!info) return info;
  const CoordinateUnits units = coordinate_units(info.value().crs());
  info.value().set_unit(units.horizontal);
  info.value().set_height_unit(units.vertical);
  return info;
}

Reply<std::string> Results::versions(std::string_view name) {
  const auto there = folders_.exists(name);
  if (!there) return problem_of(there.error());
  if (!there.value()) return problem(404, "there is no triangulation '" + std::string(name) + "'", Errc::usage);
  auto told = describe_versions_of(folders_.folder(name).string(), std::string(name));
  if (!told) return problem_of(told.error());
  return std::move(told).value();
}

Reply<ServedFile> Results::file(std::string_view name, std::string_view path) { return folders_.file(name, path); }

Reply<void> Results::remove(std::string_view name, const Caller& caller) {
  std::filesystem::path gone;
  {
    const std::lock_guard changes(table_.changing);
    const auto there = folders_.exists(name);
    if (!there) return problem_of(there.error());
    if (!there.value()) return problem(404, "there is no triangulation '" + std::string(name) + "'", Errc::usage);
    if (const auto live = admission_.live_result(name)) return *live;
    const std::lock_guard lock(table_.mutex);
    for (const auto& id : table_.active) {
      const auto& record = table_.jobs.at(id)->record;
      if (record.triangulation() == name || second_result_read(record.inputs()) == name)
        return problem(409,
                       "triangulation '" + std::string(name) + "': job " + id +
                           " works on it; wait for that job to end, or dismiss it",
                       Errc::usage);
    }
    const auto owner = admission_.owner_of_result(std::string(name));
    if (!owner) return problem_of(owner.error());
    if (!may_remove(owner.value(), caller))
      return problem(403, "triangulation '" + std::string(name) + "': only its owner or an admin may remove it",
                     Errc::usage);
    auto taken = folders_.take_away(name);
    if (!taken) return problem_of(taken.error());
    questions_.close(name);
    gone = std::move(taken).value();
  }
  if (const auto discarded = ResultFolders::discard(gone); !discarded) return problem_of(discarded.error());
  return success();
}

Reply<void> Results::remove_export(std::string_view name, std::string_view file, const Caller& caller) {
  const std::string triangulation(name), output(file);
  const std::lock_guard changes(table_.changing);
  const auto there = [&]() -> Result<bool> {
    BOOST_OUTCOME_TRY(result, folders_.exists(name));
    if (!result || !check_name(file)) return false;
    return folders_.export_exists(name, output);
  }();
  if (!there) return problem_of(there.error());
  if (!there.value())
    return problem(404, "triangulation '" + triangulation + "' has no export '" + output + "'", Errc::usage);
  const auto owner = folders_.export_owner(name, output);
  if (!owner) return problem_of(owner.error());
  std::string last;  // the job that has made it
  {
    const std::lock_guard lock(table_.mutex);
    for (const auto& [id, job] : table_.jobs) {
      const auto& record = job->record;
      if (record.triangulation() != name || export_output(record.inputs()) != output) continue;
      if (table_.active.contains(id))
        return problem(409,
                       "export '" + output + "': job " + id + " works on it; wait for that job to end, or dismiss it",
                       Errc::usage);
      if (job->is(job_state::successful)) last = id;
    }
    if (!may_remove(owner.value(), caller))
      return problem(403, "export '" + output + "': only its owner or an admin may remove it", Errc::usage);
  }
  std::set<std::string> names{output};
  if (const auto found = jobs_.outcome(last)) names.merge(exports_in(found.value()));
  for (const auto& each : names) {
    const auto stands = folders_.export_exists(name, each);
    if (!stands) return problem_of(stands.error());
    if (!stands.value()) continue;
    // A file that the job wrote beside it may have been replaced since.
    const auto of_each = folders_.export_owner(name, each);
    if (!of_each) return problem_of(of_each.error());
    if (of_each.value() != owner.value()) continue;
    if (const auto removed = folders_.remove_export(name, each); !removed) return problem_of(removed.error());
  }
  return success();
}

Reply<proto::ExportList> Results::exports(std::string_view name, std::uint32_t limit, std::string_view after) {
  const auto there = folders_.exists(name);
  if (!there) return problem_of(there.error());
  if (!there.value()) return problem(404, "there is no triangulation '" + std::string(name) + "'");
  const fs::path folder = exports_folder(folders_.folder(name));
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
    const std::lock_guard lock(table_.mutex);
    for (const auto& [id, job] : table_.jobs) {
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

}  // namespace tessera::service
