// What a process is asked to do, from fields to the options that the engine has: the only place where they meet.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/job/job_options.h"
#include "src/job/region_job.h"
#include "src/result/export/export.h"
#include "src/result/verify/verify.h"

namespace tessera {

// What one job of the service has.
struct JobShare {
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
};

// Options of `tessera triangulate` that are no fields: input-list, a file whose lines would name files anywhere (its
// lines can be sent); standard input; resume, a request of its own; config, quiet, json and verbose, which say how a
// command reads and prints. A file as crs is refused, its content is taken. Threads and memory are at most the share.
// Inputs and output are left to the caller. Error usage, here and below, with options marked.
Result<JobOptions> job_options(const proto::TriangulateInputs& inputs, const JobShare& share);
// Those that info has, too; and region.
Result<proto::TriangulateInputs> cloud_of(const proto::InfoInputs& inputs);
Result<proto::TriangulateInputs> cloud_of(const proto::RegionInputs& inputs);
// All but `command`.
Result<RegionJobOptions> region_options(const proto::RegionInputs& inputs, const JobShare& share);
// `scratch` is not asked for: it is the service's.
Result<VerifyOptions> verify_options(const proto::VerifyInputs& inputs, const JobShare& share);
Result<ExportOptions> export_options(const proto::ExportInputs& inputs);

// "memory: 4.00 GiB asked for, a job has 1.00 GiB here; ...", options marked; empty when nothing beyond the share is
// asked for. What is asked for are bounds: less than that is no other result, so that the job is taken, and told.
std::string beyond_share(const proto::Inputs& inputs, const JobShare& share);

// A length, finite and above 0, that the option of this key gives.
Result<double> length_of(const char* key, double value);
// Of inputs with threads and memory: what is asked for, at most the share.
Result<std::uint32_t> threads_of(std::uint32_t asked, const JobShare& share);
Result<std::uint64_t> memory_of(const std::string& text, const JobShare& share);
template <class Inputs>
Result<JobShare> share_of_job(const Inputs& inputs, const JobShare& share) {
  JobShare own = share;
  if (inputs.has_threads()) {
    BOOST_OUTCOME_TRY(threads, threads_of(inputs.threads(), share));
    own.threads = threads;
  }
  if (inputs.has_memory()) {
    BOOST_OUTCOME_TRY(bytes, memory_of(inputs.memory(), share));
    own.memory_bytes = bytes;
  }
  return own;
}

std::vector<std::string> list_of(const google::protobuf::RepeatedPtrField<std::string>& texts);

}  // namespace tessera
