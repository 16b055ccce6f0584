// Decides whether a job is accepted.
#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "src/job/open_cloud.h"
#include "src/job/report/human.h"
#include "src/service/processes/costs.h"
#include "src/service/deadline.h"
#include "src/service/processes/drawing_options.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/results/owners.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"
#include "src/service/processes/work_region.h"

namespace tessera {
namespace {

using std::chrono::system_clock;

constexpr std::size_t key_bytes_max = 255;
constexpr std::uint64_t info_points_max = 20'000'000;  // some seconds
constexpr std::size_t files_opened_max = 10'000;       // while a request waits: again some seconds

std::optional<proto::Problem> check_field_name(const char* field, const std::string& name) {
  const auto fits = check_name(name);
  if (fits) return std::nullopt;
  return problem(400, std::string(field) + ": '" + name + "' " + fits.error().where, Errc::usage);
}

}  // namespace

std::optional<proto::Problem> Service::Impl::check_inputs(const proto::Inputs& inputs,
                                                          std::string& triangulation) const {
  const auto read_from = [&](const std::string& name) -> std::optional<proto::Problem> {
    if (const auto bad = check_field_name("triangulation", name)) return bad;
    triangulation = name;
    const auto there = results.exists(name);
    if (!there) return problem_of(there.error());
    if (there.value()) return std::nullopt;
    return problem(422, "triangulation: there is none called '" + name + "'", Errc::usage);
  };
  if (inputs.of_case() == proto::Inputs::OF_NOT_SET)
    return problem(400, "inputs: those of no process are given", Errc::usage);
  if (const auto bad = check_size(inputs)) return bad;
  if (const auto bad = check_options(inputs)) return bad;
  if (makes_result(inputs)) {
    triangulation = result_output(inputs);
    if (!triangulation.empty())
      if (const auto bad = check_field_name("output", triangulation)) return bad;
  }
  if (const auto output = export_output(inputs))
    if (const auto bad = check_field_name("output", *output)) return bad;
  if (const auto name = result_read(inputs); inputs.has_info() ? !name.empty() : !makes_result(inputs))
    if (const auto bad = read_from(name)) return bad;
  if (inputs.has_verify()) return check_verify(shop, inputs.verify());
  if (inputs.has_region() || (inputs.has_info() && inputs.info().triangulation().empty())) {
    const auto& names = inputs.has_region() ? inputs.region().inputs() : inputs.info().inputs();
    const bool recursive = inputs.has_region() ? inputs.region().recursive() : inputs.info().recursive();
    const auto files = roots.files(list_of(names), recursive);
    if (!files && !Ledger::reason_of_thread()) return problem_of_inputs(files.error());
  }
  return std::nullopt;
}

std::optional<proto::Problem> Service::Impl::check_options(const proto::Inputs& inputs) const {
  const auto told = [](const auto& options) -> std::optional<proto::Problem> {
    return options ? std::nullopt : std::optional(problem_of(options.error()));
  };
  const auto ends = [&](const char* ending, const char* other) -> std::optional<proto::Problem> {
    const std::string output = *export_output(inputs);
    if (output.ends_with(ending) || output.ends_with(other)) return std::nullopt;
    return problem(400, "output: '" + output + "' must end in " + ending + " or " + other, Errc::usage);
  };
  switch (inputs.of_case()) {
    case proto::Inputs::kVerify:
      return told(verify_options(inputs.verify(), share));
    case proto::Inputs::kExport:
      return told(export_options(inputs.export_()));
    case proto::Inputs::kInfo: {
      const auto cloud = cloud_of(inputs.info());
      return cloud ? told(job_options(cloud.value(), share)) : problem_of(cloud.error());
    }
    case proto::Inputs::kRegion:
      return told(region_options(inputs.region(), share));
    case proto::Inputs::kDem:
      if (const auto bad = told(dem_options(inputs.dem(), share))) return bad;
      return ends(".tif", ".tiff");
    case proto::Inputs::kContours:
      if (const auto bad = told(contour_options(inputs.contours(), share))) return bad;
      return ends(".gpkg", ".geojson");
    case proto::Inputs::kSurface:
      return told(surface_options(inputs.surface(), share));
    default:
      return std::nullopt;  // the inputs of a triangulation are checked with its costs
  }
}

Reply<proto::Estimate> Service::Impl::costs(const proto::Inputs& inputs, std::optional<proto::Problem>& refused) {
  if (inputs.has_triangulate()) return costs(inputs.triangulate(), refused);
  if (inputs.has_region()) {
    auto told = region_estimate(shop, inputs.region());
    return told ? Reply<proto::Estimate>(std::move(told).value()) : in_callers_words(problem_of_inputs(told.error()));
  }
  const std::string name = result_read(inputs);
  const auto manifest = results.manifest(name);
  if (!manifest) return problem_of(manifest.error());
  proto::Estimate estimate;
  if (inputs.has_dem()) {
    const auto options = dem_options(inputs.dem(), share);
    if (!options) return problem_of(options.error());
    refused = check_costs(*manifest.value(), options.value(), shop.limits, shop.data, estimate);
  } else if (inputs.has_contours()) {
    const auto options = contour_options(inputs.contours(), share);
    if (!options) return problem_of(options.error());
    refused = check_costs(*manifest.value(), options.value(), results.folder(name), shop.limits, shop.data, estimate);
  } else if (inputs.has_export_()) {
    const auto options = export_options(inputs.export_());
    if (!options) return problem_of(options.error());
    refused =
        check_costs(*manifest.value(), options.value(), inputs.export_().output(), shop.limits, shop.data, estimate);
  } else {
    return problem(404, "the process " + process_of(inputs) + " makes no estimate", Errc::usage);
  }
  if (manifest.value()->dimension != 2 && !inputs.has_export_())
    refused =
        problem(400, "triangulation: '" + name + "' is a 3D result, which has no heights over a plane", Errc::usage);
  if (refused) estimate.set_reason(refused->detail());
  estimate.set_accepted(!refused);
  return estimate;
}

Reply<proto::Estimate> Service::Impl::costs(const proto::TriangulateInputs& inputs,
                                            std::optional<proto::Problem>& refused) const {
  auto options = job_options(inputs, share);
  if (!options) return problem_of(options.error());
  proto::Estimate estimate;
  const auto looked = [&]() -> Status {
    BOOST_OUTCOME_TRY(files, roots.files(list_of(inputs.inputs()), inputs.recursive()));
    if (files.size() > files_opened_max) {
      estimate.set_reason("more than " + grouped(files_opened_max) + " files are measured when the job runs");
      return success();
    }
    BOOST_OUTCOME_TRY(packed, any_packed(files));
    if (packed) {
      estimate.set_reason("compressed files are measured when the job runs");
      return success();
    }
    BOOST_OUTCOME_TRY(cloud, open_cloud(files, options.value(), Ledger::token_of_thread()));
    refused = check_costs(cloud, options.value(), shop.limits, shop.data, estimate, engine->shares());
    return success();
  }();
  if (!looked && !Ledger::reason_of_thread()) return in_callers_words(problem_of_inputs(looked.error()));
  if (!looked) estimate.set_reason("files that take so long are measured when the job runs");
  if (refused) estimate.set_reason(refused->detail());
  estimate.set_accepted(!refused);
  return estimate;
}

std::optional<proto::Problem> Service::Impl::conflict(const proto::JobRecord& job, const Caller& caller) {
  const auto& inputs = job.inputs();
  const auto& name = job.triangulation();
  const auto output = export_output(inputs);
  const auto clash = [](const std::string& detail) { return problem(409, detail, Errc::usage); };
  std::uint64_t of_caller = 0, bytes_of_caller = inputs.ByteSizeLong(), queued = waiting.size();
  for (const auto& id : active) {
    const Job& other = *jobs.at(id);
    // An ended job works on nothing, even if its thread has not let go of it yet.
    if (id == job.id() || other.is(job_state::successful) || other.is(job_state::failed)) continue;
    if (other.arriving) ++queued;
    if (other.waits_or_runs() && other.record.caller() == job.caller()) {
      ++of_caller;
      bytes_of_caller += other.record.inputs().ByteSizeLong();
    }
    if (name.empty() || other.record.triangulation() != name) continue;
    // A job that makes a triangulation must be alone on it. Others may read it together, but not write the same export.
    if (makes_result(inputs) || makes_result(other.record.inputs()))
      return clash("triangulation '" + name + "': job " + id + " works on it");
    if (output && export_output(other.record.inputs()) == output)
      return clash("output: job " + id + " exports to '" + *output + "' already");
  }
  if (queued >= options.limits.queued)
    return problem(429, grouped(queued) + " jobs wait already, as many as may", Errc::io);
  if (bytes_of_caller > inputs_of_caller_bytes_max)
    return problem(429,
                   "the inputs of jobs of " + job.caller() + " that wait or run take " + human_bytes(bytes_of_caller) +
                       ", more than may be",
                   Errc::io);
  if (of_caller >= options.limits.jobs_of_a_caller)
    return problem(429, grouped(of_caller) + " jobs of " + job.caller() + " wait or run, as many as may", Errc::io);
  return in_its_place(job, caller);
}

std::optional<proto::Problem> Service::Impl::in_its_place(const proto::JobRecord& job, const Caller& caller) {
  const auto& inputs = job.inputs();
  const auto& name = job.triangulation();
  // To replace is to remove, so a caller needs the same right for both.
  const auto judge = [&](const std::string& what, const Result<std::string>& owner) -> std::optional<proto::Problem> {
    if (!overwrites(inputs)) return problem(409, "output: " + what + "; overwrite: true replaces it", Errc::usage);
    if (!owner) return problem_of(owner.error());
    if (may_remove(owner.value(), caller)) return std::nullopt;
    return problem(403, "output: " + what + ", and who made it or an admin may replace it", Errc::usage);
  };
  if (makes_result(inputs) && !name.empty()) {
    const auto taken = [&]() -> Result<bool> {
      BOOST_OUTCOME_TRY(there, results.exists(name));
      if (!there) return false;
      BOOST_OUTCOME_TRY(own, results.made_by(name, job.id()));
      return !own;
    }();
    if (!taken) return problem_of(taken.error());
    if (taken.value()) return judge("there is a triangulation called '" + name + "' already", owner_of_result(name));
  }
  const auto output = export_output(inputs);
  const auto taken = output ? results.export_exists(name, *output) : Result<bool>(false);
  if (!taken) return problem_of(taken.error());
  if (taken.value())
    return judge("'" + name + "' has an export of this name already", results.export_owner(name, *output));
  return std::nullopt;
}

std::optional<Service::Submitted> Service::Impl::same_as(const proto::Inputs& inputs, const Caller& caller,
                                                         const std::string& key, std::unique_lock<std::mutex>& lock,
                                                         std::optional<proto::Problem>& other) {
  if (key.empty()) return std::nullopt;
  const auto known = [&] { return by_key.find({caller.name, key}); };
  arrived.wait(lock, [&] { return known() == by_key.end() || !jobs.at(known()->second)->arriving; });
  const auto found = known();
  if (found == by_key.end()) return std::nullopt;
  const Job& job = *jobs.at(found->second);
  if (same_inputs(job.record, inputs)) return Service::Submitted{status_of(job), false};
  other = problem(422, "this idempotency key was sent before with other inputs, for job " + found->second, Errc::usage);
  return std::nullopt;
}

Reply<std::shared_ptr<Job>> Service::Impl::admit(proto::JobRecord record, const Caller& caller) {
  record.set_id(ids.next(system_clock::now()));
  record.set_place(next_place++);
  record.set_state(job_state::accepted);
  if (makes_result(record.inputs()) && record.triangulation().empty()) record.set_triangulation(record.id());
  record.set_created(time_text(system_clock::now()));
  record.set_updated(record.created());
  if (const auto against = conflict(record, caller)) return *against;
  const auto job = std::make_shared<Job>();
  job->record = std::move(record);
  job->arriving = true;
  const auto& id = job->record.id();
  jobs[id] = job;
  active.insert(id);
  if (!job->record.idempotency_key().empty()) by_key[{job->record.caller(), job->record.idempotency_key()}] = id;
  return job;
}

Reply<Service::Submitted> Service::Impl::welcome(const std::shared_ptr<Job>& job, const Status& added) {
  const std::lock_guard lock(mutex);
  const auto& record = job->record;
  job->arriving = false;
  arrived.notify_all();
  if (!added) {
    jobs.erase(record.id());
    active.erase(record.id());
    by_key.erase({record.caller(), record.idempotency_key()});
    return problem_of(added.error());
  }
  waiting[record.place()] = record.id();
  tell_status(*job);
  waiting_changed.notify_all();
  return Service::Submitted{status_of(*job), true};
}

Reply<Service::Submitted> Service::submit(const proto::Inputs& inputs, const Caller& caller,
                                          std::string_view idempotency_key) {
  auto& impl = *impl_;
  if (caller.role < Role::submit) return problem(403, "submitting takes the role submit", Errc::usage);
  if (idempotency_key.size() > key_bytes_max)
    return problem(400, "the idempotency key is longer than " + std::to_string(key_bytes_max) + " bytes", Errc::usage);
  const std::string key = problem(0, idempotency_key).detail();  // as it will be stored: UTF-8
  proto::JobRecord record;
  std::optional<proto::Problem> other;
  {
    std::unique_lock lock(impl.mutex);
    if (const auto same = impl.same_as(inputs, caller, key, lock, other)) return *same;
    if (other) return *other;
  }
  std::string triangulation;
  std::optional<WhileAnyoneWaits> waited(std::in_place, caller.stop);
  if (const auto bad = impl.check_inputs(inputs, triangulation)) return *bad;
  // The costs of a region are known when its files were read, which the job does.
  if (inputs.has_triangulate() || inputs.has_dem() || inputs.has_contours() || inputs.has_export_()) {
    std::optional<proto::Problem> refused;
    BOOST_OUTCOME_TRY(estimate, impl.costs(inputs, refused));
    if (refused) return *refused;
    if (inputs.has_triangulate()) record.set_points(estimate.points());
    record.set_memory_bytes(estimate.memory_bytes());
    record.set_disk_bytes(estimate.result_bytes() + estimate.temporary_bytes());
  }
  waited.reset();
  *record.mutable_inputs() = inputs;
  record.set_inputs_sum(sum_of(inputs));
  record.set_caller(caller.name);
  record.set_idempotency_key(key);
  record.set_triangulation(triangulation);
  std::unique_lock lock(impl.mutex);
  // Another request may have been faster.
  if (const auto same = impl.same_as(inputs, caller, key, lock, other)) return *same;
  if (other) return *other;
  const std::string beyond = problem(0, beyond_share(inputs, impl.share)).detail();  // options get the names of fields
  record.set_message("waits" + (beyond.empty() ? "" : "; " + beyond));
  BOOST_OUTCOME_TRY(job, impl.admit(std::move(record), caller));
  lock.unlock();
  Status added = success();
  try {
    added = impl.store.add(job->record);
  } catch (const std::exception& thrown) {  // requests that wait for the job's key must be told
    added = error(Errc::internal, thrown.what());
  }
  if (added && !beyond.empty()) impl.log(job->record.id(), "note: " + beyond);
  return impl.welcome(job, added);
}

Reply<proto::Estimate> Service::estimate(const proto::Inputs& inputs, const Caller& caller) {
  const bool reads_inputs = makes_result(inputs);
  if (caller.role < (reads_inputs ? Role::submit : Role::read))
    return problem(403, "an estimate reads inputs: it takes the role submit", Errc::usage);
  std::string triangulation;
  const WhileAnyoneWaits waited(caller.stop);
  if (!inputs.has_triangulate())
    if (const auto bad = impl_->check_inputs(inputs, triangulation)) return *bad;
  std::optional<proto::Problem> refused;
  return impl_->costs(inputs, refused);
}

Reply<std::string> Service::info(const proto::InfoInputs& inputs, const Caller& caller) {
  if (caller.role < (inputs.triangulation().empty() ? Role::submit : Role::read))
    return problem(403, "to be told of inputs takes the role submit", Errc::usage);
  const auto refuse = [&](const Error& failed) {
    return impl_->in_callers_words(inputs.triangulation().empty() ? problem_of_inputs(failed) : problem_of(failed));
  };
  WhileAnyoneWaits waited(caller.stop);
  const auto late = takes_too_long(impl_->shop, inputs, info_points_max);
  if (!late) return refuse(late.error());
  if (late.value()) return *late.value();
  auto text = describe_inputs(impl_->shop, inputs, waited.ledger().token());
  if (!text) return refuse(waited.ledger().reason().value_or(text.error()));
  return std::move(text).value();
}

}  // namespace tessera
