// A process: what a caller can have done as a job. Each process is a row of the table (table.h), in a file of its own.
//
// To add a process: give it a message of inputs in proto/service.proto, and a member of its name in the oneof of
// Inputs; write its file, its row in table.cc, and what its inputs mean in helps.cc. The routes, the OpenAPI document
// and the schemas follow.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "service.pb.h"
#include "src/service/reply.h"

namespace tessera::service {

struct JobDone;
struct JobShare;
struct JobWork;
struct Workshop;

struct Process {
  enum class Makes : std::uint8_t {
    nothing,  // but an outcome
    result,   // with the name in the field `output`
    file,     // an export of the result in the field `triangulation`, with the name in the field `output`
    columns,  // a new version of the result in the field `triangulation`
    change    // likewise; or with the field `output` a result; or with `dry_run` nothing
  };
  // Whether the inputs name a result in the field `triangulation`, which the process reads.
  enum class Reads : std::uint8_t { no_result, a_result, perhaps_a_result };
  // When the cost is known, and may be refused.
  enum class Costs : std::uint8_t { unknown, on_request, before_it_waits };

  const char* name;  // also of the member in the oneof of proto::Inputs
  const char* title;
  const char* description;
  const char* outcome;  // description of the outcome
  Reads reads = Reads::no_result;
  Makes makes = Makes::nothing;
  bool waits = false;  // answered at once, unless a job is asked for; else always a job
  Costs costs = Costs::unknown;

  // The name of the file that is made when the inputs give none; null when they must give one.
  std::string (*usual_output)(const proto::Inputs& inputs) = nullptr;
  // Before the job is accepted: the problem of options that make no sense, looked at alone; and that of inputs which
  // cannot be worked on, when names of results are known to exist. Null: nothing is to be checked.
  std::optional<proto::Problem> (*check_options)(const proto::Inputs& inputs, const JobShare& share) = nullptr;
  std::optional<proto::Problem> (*check)(const Workshop& shop, const proto::Inputs& inputs) = nullptr;
  // Estimates the cost. `refused` gets the problem of a job that costs too much. Null where `costs` is unknown.
  Reply<proto::Estimate> (*estimate)(const Workshop& shop, const proto::Inputs& inputs,
                                     std::optional<proto::Problem>& refused) = nullptr;
  // Does a job. When this returns without a problem, a result is complete in ResultFolders::unfinished(job), an export
  // in ResultFolders::unfinished_export(), and nothing was written elsewhere. Columns are committed as a new version,
  // under the lock of the result's folder (src/result/new_version.h). After a problem with the cause
  // interrupted, the same job can continue later from where it was. After other problems, files of no further use are
  // removed.
  Reply<JobDone> (*run)(const Workshop& shop, const JobWork& work) = nullptr;

  bool estimated() const { return costs != Costs::unknown; }
};

}  // namespace tessera::service
