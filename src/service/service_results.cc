// Results and uploads, and the figures and health of the service.
#include <fcntl.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "src/base/crs/survey_system.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/json/json_text.h"
#include "src/job/report/human.h"
#include "src/service/processes/costs.h"
#include "src/service/results/owners.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"

namespace tessera {
namespace {

std::optional<proto::Problem> no_uploads(const ServiceOptions& options) {
  if (options.uploads) return std::nullopt;
  return problem(403,
                 "this service takes no uploads; who runs it can allow them (uploads), or offer the files as inputs",
                 Errc::usage);
}

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

}  // namespace

Reply<proto::TriangulationList> Service::triangulations(std::uint32_t limit, std::string_view after) {
  const auto found = impl_->results.names();
  if (!found) return problem_of(found.error());
  const auto& names = found.value();
  proto::TriangulationList list;
  list.set_number_matched(names.size());
  for (auto name = std::upper_bound(names.begin(), names.end(), after); name != names.end(); ++name) {
    if (static_cast<std::uint32_t>(list.triangulations_size()) >= limit) break;
    auto info = impl_->results.info(*name);
    if (!info) {  // damaged or gone meanwhile: it must not hide the others
      impl_->tell("triangulation '" + *name + "': " + info.error().detail());
      list.add_triangulations()->set_name(*name);
      continue;
    }
    *list.add_triangulations() = std::move(info).value();
  }
  return list;
}

Result<std::string> Service::Impl::owner_of_result(const std::string& name) {
  BOOST_OUTCOME_TRY(maker, results.maker(name));
  if (!maker.owner.empty()) return maker.owner;
  const auto job = jobs.find(maker.job);  // results from before manifests had the owner
  return job == jobs.end() ? std::string() : job->second->record.caller();
}

Reply<proto::TriangulationInfo> Service::triangulation(std::string_view name) {
  auto info = impl_->results.info(name);
  if (!info) return info;
  const CoordinateUnits units = coordinate_units(info.value().crs());
  info.value().set_unit(units.horizontal);
  info.value().set_height_unit(units.vertical);
  return info;
}

Reply<ServedFile> Service::file(std::string_view name, std::string_view path) {
  return impl_->results.file(name, path);
}

Reply<void> Service::remove_triangulation(std::string_view name, const Caller& caller) {
  auto& impl = *impl_;
  std::filesystem::path gone;
  {
    const std::lock_guard changes(impl.changing);
    const auto there = impl.results.exists(name);
    if (!there) return problem_of(there.error());
    if (!there.value()) return problem(404, "there is no triangulation '" + std::string(name) + "'", Errc::usage);
    const std::lock_guard lock(impl.mutex);
    for (const auto& id : impl.active) {
      if (impl.jobs.at(id)->record.triangulation() == name)
        return problem(409, "triangulation '" + std::string(name) + "': job " + id + " works on it", Errc::usage);
    }
    const auto owner = impl.owner_of_result(std::string(name));
    if (!owner) return problem_of(owner.error());
    if (!may_remove(owner.value(), caller))
      return problem(403, "triangulation '" + std::string(name) + "': who made it or an admin may remove it",
                     Errc::usage);
    auto taken = impl.results.take_away(name);
    if (!taken) return problem_of(taken.error());
    impl.questions.close(name);
    gone = std::move(taken).value();
  }
  if (const auto discarded = Results::discard(gone); !discarded) return problem_of(discarded.error());
  return success();
}

Reply<void> Service::remove_export(std::string_view name, std::string_view file, const Caller& caller) {
  auto& impl = *impl_;
  const std::string triangulation(name), output(file);
  const std::lock_guard changes(impl.changing);
  const auto there = [&]() -> Result<bool> {
    BOOST_OUTCOME_TRY(result, impl.results.exists(name));
    if (!result || !check_name(file)) return false;
    return impl.results.export_exists(name, output);
  }();
  if (!there) return problem_of(there.error());
  if (!there.value())
    return problem(404, "triangulation '" + triangulation + "' has no export '" + output + "'", Errc::usage);
  const auto owner = impl.results.export_owner(name, output);
  if (!owner) return problem_of(owner.error());
  std::string last;  // the job that has made it
  {
    const std::lock_guard lock(impl.mutex);
    for (const auto& [id, job] : impl.jobs) {
      const auto& record = job->record;
      if (record.triangulation() != name || export_output(record.inputs()) != output) continue;
      if (impl.active.contains(id))
        return problem(409, "export '" + output + "': job " + id + " works on it", Errc::usage);
      if (job->is(job_state::successful)) last = id;
    }
    if (!may_remove(owner.value(), caller))
      return problem(403, "export '" + output + "': who made it or an admin may remove it", Errc::usage);
  }
  std::set<std::string> names{output};
  if (const auto found = outcome(last)) names.merge(exports_in(found.value()));
  for (const auto& each : names) {
    const auto stands = impl.results.export_exists(name, each);
    if (!stands) return problem_of(stands.error());
    if (!stands.value()) continue;
    // A file that the job wrote beside it may have been replaced since.
    const auto of_each = impl.results.export_owner(name, each);
    if (!of_each) return problem_of(of_each.error());
    if (of_each.value() != owner.value()) continue;
    if (const auto removed = impl.results.remove_export(name, each); !removed) return problem_of(removed.error());
  }
  return success();
}

Reply<std::unique_ptr<Service::Upload>> Service::upload(std::string_view folder, std::string_view file,
                                                        std::uint64_t offset, const Caller& caller) {
  if (const auto refused = no_uploads(impl_->options)) return *refused;
  if (caller.role < Role::submit) return problem(403, "an upload takes the role submit", Errc::usage);
  return impl_->uploads.begin(folder, file, offset, caller);
}

Reply<std::uint64_t> Service::uploaded(std::string_view folder, std::string_view file) {
  if (const auto refused = no_uploads(impl_->options)) return *refused;
  return impl_->uploads.uploaded(folder, file);
}

Reply<void> Service::remove_upload(std::string_view folder, std::string_view file, const Caller& caller) {
  if (const auto refused = no_uploads(impl_->options)) return *refused;
  if (caller.role < Role::submit) return problem(403, "to remove an upload takes the role submit", Errc::usage);
  return impl_->uploads.remove(folder, file, caller);
}

Reply<std::string> Service::identity(std::string_view name) { return impl_->questions.identity(name); }

Reply<QuestionAnswer> Service::ask(const Question& question) { return impl_->questions.ask(question); }

Reply<std::vector<FeatureCollection>> Service::collections() { return impl_->maps.list(); }
Reply<FeatureCollection> Service::collection(std::string_view id) { return impl_->maps.find(id); }
Reply<std::array<double, 4>> Service::map_extent(std::string_view name) { return impl_->maps.map_extent(name); }

Service::Figures Service::figures() const {
  // Before the lock, because this asks the cluster's coordinator.
  std::vector<std::pair<std::string, std::uint64_t>> nodes{{"joining", 0}, {"free", 1}};
  std::uint64_t lost = 0;
  if (impl_->options.cluster) {
    const auto all = impl_->engine->nodes();
    const auto count =
        static_cast<std::uint64_t>(std::count_if(all.begin(), all.end(), [](const NodeState& n) { return n.free; }));
    nodes = {{"joining", all.size() - count}, {"free", count}};
    lost = impl_->engine->nodes_lost();
  }
  const std::lock_guard lock(impl_->mutex);
  Figures figures = impl_->since_start;
  figures.nodes = std::move(nodes);
  figures.nodes_lost = lost;
  if (impl_->options.cluster)
    figures.certificate_end_s = static_cast<double>(impl_->options.cluster->certificate_end_s);
  for (const auto& id : impl_->active) {
    const Job& job = *impl_->jobs.at(id);
    if (job.is(job_state::accepted)) ++figures.accepted;
    if (job.is(job_state::running)) ++figures.running;
    if (!job.running) continue;
    const auto& progress = job.running->progress;
    figures.memory_used_bytes += progress.memory_bytes;
    figures.bytes_between += progress.bytes_between;
    figures.credit_waits += progress.credit_waits;
    // In this order: updates that are sent between the two reads count as waiting, and the difference is never
    // negative.
    const std::uint64_t processed = progress.updates_processed;
    figures.updates_waiting += std::max(processed, progress.updates_sent.load()) - processed;
  }
  figures.memory_budget_bytes = impl_->options.memory_bytes;
  figures.disk_free_bytes = free_bytes(impl_->options.data);
  figures.phase_seconds = {impl_->phase_seconds.begin(), impl_->phase_seconds.end()};
  figures.open_results = impl_->questions.open_results();
  figures.subscribers = impl_->events->listeners();
  return figures;
}

std::optional<std::string> Service::lost() const {
  const auto held = impl_->data_folder->heard();
  return held ? std::nullopt : std::optional(held.error().where);
}

std::optional<std::string> Service::unready() const {
  constexpr std::uint64_t free_min = std::uint64_t{16} << 20;  // records and logs of many jobs
  constexpr std::chrono::seconds silence_max{30};
  if (const auto held = impl_->data_folder->still_ours(); !held) return held.error().where;
  const auto writable = nameless_file(impl_->options.data);
  if (!writable) return problem_of(writable.error()).detail();
  if (const auto free = free_bytes(impl_->options.data); free < free_min)
    return impl_->options.data.string() + ": only " + human_bytes(free) + " are free";
  const std::lock_guard lock(impl_->mutex);
  if (!impl_->unwritten.empty())
    return "the state of " + grouped(impl_->unwritten.size()) + " jobs could not be written to " +
           impl_->options.data.string();
  if (std::chrono::steady_clock::now() - impl_->ticked > silence_max)
    return "the thread that watches the jobs does not answer";
  return std::nullopt;
}

}  // namespace tessera
