#include "src/service/processes/processes.h"

#include <algorithm>
#include <utility>

#include "src/service/deadline.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/service/processes/info.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/table.h"

namespace tessera::service {
namespace {

constexpr std::size_t key_bytes_max = 255;
constexpr std::uint64_t info_points_max = 20'000'000;  // some seconds

std::optional<proto::Problem> check_field_name(const char* field, const std::string& name) {
  const auto fits = check_name(name);
  if (fits) return std::nullopt;
  return problem(400, std::string(field) + ": '" + name + "' " + fits.error().where, Errc::usage);
}

std::optional<proto::Problem> check_exists(const ResultFolders& results, const char* field, const std::string& name) {
  if (auto bad = check_field_name(field, name)) return bad;
  const auto there = results.exists(name);
  if (!there) return problem_of(there.error());
  if (there.value()) return std::nullopt;
  return problem(422, std::string(field) + ": there is none called '" + name + "'", Errc::usage);
}

std::optional<proto::Problem> check_version(ResultFolders& results, const std::string& name,
                                            const proto::Inputs& inputs) {
  const std::uint32_t version = version_read(inputs);
  if (version == 0) return std::nullopt;
  const auto held = results.hold(name, version);
  if (held) return std::nullopt;
  if (held.error().code != Errc::usage) return problem_of(held.error());
  // The sentence begins with the folder, which means nothing to a caller.
  const auto& said = held.error().where;
  return problem(422, "version: '" + name + "'" + said.substr(std::min(said.find(": "), said.size())), Errc::usage);
}

}  // namespace

std::optional<proto::Problem> Processes::check(const proto::Inputs& inputs, std::string& triangulation) const {
  const Process* process = find_process(process_of(inputs));
  if (process == nullptr) return problem(400, "inputs: the inputs of a process are missing", Errc::usage);
  if (auto bad = check_size(inputs)) return bad;
  if (process->check_options != nullptr)
    if (auto bad = process->check_options(inputs, shop_.share)) return bad;
  if (makes_result(inputs)) {
    triangulation = result_output(inputs);
    if (!triangulation.empty())
      if (auto bad = check_field_name("output", triangulation)) return bad;
  }
  if (const auto output = export_output(inputs))
    if (auto bad = check_field_name("output", *output)) return bad;
  const auto name = result_read(inputs);
  const bool reads = process->reads == Process::Reads::a_result ||
                     (process->reads == Process::Reads::perhaps_a_result && !name.empty());
  if (reads) {
    if (auto bad = check_exists(shop_.results, "triangulation", name)) return bad;
    if (!makes_result(inputs)) triangulation = name;
    if (auto bad = check_version(shop_.results, name, inputs)) return bad;
  }
  if (const auto second = second_result_read(inputs); !second.empty() && second != name)
    if (auto bad = check_exists(shop_.results, "second", second)) return bad;
  return process->check == nullptr ? std::nullopt : process->check(shop_, inputs);
}

Reply<Submitted> Processes::submit(const proto::Inputs& inputs, const Caller& caller,
                                   std::string_view idempotency_key) {
  if (caller.role < Role::submit) return problem(403, "submitting a job needs a token of role submit", Errc::usage);
  if (idempotency_key.size() > key_bytes_max)
    return problem(400, "the idempotency key is longer than " + std::to_string(key_bytes_max) + " bytes", Errc::usage);
  const std::string key = problem(0, idempotency_key).detail();  // as it will be stored: UTF-8
  BOOST_OUTCOME_TRY(same, admission_.same_as(inputs, caller, key));
  if (same) return *std::move(same);
  proto::JobRecord record;
  std::string triangulation;
  {
    const WhileAnyoneWaits waited(caller.stop);
    if (const auto bad = check(inputs, triangulation)) return *bad;
    const Process& process = *find_process(process_of(inputs));
    if (process.costs == Process::Costs::before_it_waits) {
      std::optional<proto::Problem> refused;
      BOOST_OUTCOME_TRY(cost, process.estimate(shop_, inputs, refused));
      if (refused) return *refused;
      if (process.makes == Process::Makes::result) record.set_points(cost.points());
      record.set_memory_bytes(cost.memory_bytes());
      record.set_disk_bytes(cost.result_bytes() + cost.temporary_bytes());
    }
  }
  *record.mutable_inputs() = inputs;
  record.set_inputs_sum(sum_of(inputs));
  record.set_caller(caller.name);
  record.set_idempotency_key(key);
  record.set_triangulation(triangulation);
  const std::string beyond = problem(0, beyond_share(inputs, shop_.share)).detail();  // options get the names of fields
  record.set_message("waits" + (beyond.empty() ? "" : "; " + beyond));
  return admission_.accept(std::move(record), caller, beyond.empty() ? "" : "note: " + beyond);
}

Reply<proto::Estimate> Processes::estimate(const proto::Inputs& inputs, const Caller& caller) {
  const bool reads_inputs = makes_result(inputs) || inputs.has_update();
  if (caller.role < (reads_inputs ? Role::submit : Role::read))
    return problem(403, "an estimate that reads input files needs a token of role submit", Errc::usage);
  const WhileAnyoneWaits waited(caller.stop);
  std::string triangulation;
  // The inputs of a triangulation are checked with its costs.
  if (!inputs.has_triangulate())
    if (const auto bad = check(inputs, triangulation)) return *bad;
  const Process* process = find_process(process_of(inputs));
  if (process == nullptr || !process->estimated())
    return problem(404, "the process " + process_of(inputs) + " makes no estimate", Errc::usage);
  std::optional<proto::Problem> refused;
  return process->estimate(shop_, inputs, refused);
}

Reply<std::string> Processes::info(const proto::InfoInputs& inputs, const Caller& caller) {
  if (caller.role < (inputs.triangulation().empty() ? Role::submit : Role::read))
    return problem(403, "describing input files needs a token of role submit", Errc::usage);
  const auto refuse = [&](const Error& failed) {
    return in_callers_words(shop_, inputs.triangulation().empty() ? problem_of_inputs(failed) : problem_of(failed));
  };
  WhileAnyoneWaits waited(caller.stop);
  const auto late = takes_too_long(shop_, inputs, info_points_max);
  if (!late) return refuse(late.error());
  if (late.value()) return *late.value();
  auto text = describe_inputs(shop_, inputs, waited.ledger().token());
  if (!text) return refuse(waited.ledger().reason().value_or(text.error()));
  return std::move(text).value();
}

}  // namespace tessera::service
