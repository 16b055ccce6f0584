// Converts the inputs of a process to the options of the engine. This is the only place that knows both.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/job/job_options.h"
#include "src/job/region_job.h"
#include "src/result/export/export.h"
#include "src/result/heights/heights.h"
#include "src/result/measure/measure.h"
#include "src/result/verify/verify.h"

namespace tessera::service {

// The threads and the memory of one job of the service.
struct JobShare {
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
};

// The options of a triangulation. Some options of `tessera triangulate` are no fields: input-list, because its lines
// could name any file (a client can send the lines instead); standard input; resume, which is a request of its own;
// config, quiet, json and verbose, which are about the command. A file as crs is refused; its content is accepted.
// Threads and memory are at most the share. The caller sets inputs and output. Error usage, here and below, with marks
// for options.
Result<JobOptions> job_options(const proto::TriangulateInputs& inputs, const JobShare& share);
// The inputs that info and region have in common with triangulate.
Result<proto::TriangulateInputs> cloud_of(const proto::InfoInputs& inputs);
Result<proto::TriangulateInputs> cloud_of(const proto::RegionInputs& inputs);
// All region options except `command`.
Result<RegionJobOptions> region_options(const proto::RegionInputs& inputs, const JobShare& share);
// Leaves `scratch` to the caller, because it is the service's.
Result<VerifyOptions> verify_options(const proto::VerifyInputs& inputs, const JobShare& share);
Result<ExportOptions> export_options(const proto::ExportInputs& inputs);
Result<HeightsOptions> heights_options(const proto::HagInputs& inputs, const JobShare& share);
Result<MeasureOptions> measure_options(const proto::MeasureInputs& inputs, const JobShare& share);

// Describes what is asked for beyond the share, with marks for options: "memory: 4.00 GiB asked for, a job has 1.00 GiB
// here; ..."; empty when nothing is. Threads and memory are upper bounds, and less of them gives the same result. So
// the job is accepted, with this message.
std::string beyond_share(const proto::Inputs& inputs, const JobShare& share);

// Checks that `value`, of the option `key`, is a length: finite and above 0.
Result<double> length_of(const char* key, double value);
// Threads and memory that inputs ask for, at most the share.
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

}  // namespace tessera::service
