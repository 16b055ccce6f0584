// What a process is asked to do, from fields to the options that the engine has: the only place where they meet.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/export/export.h"
#include "src/job/job_options.h"
#include "src/verify/verify.h"

namespace tessera {

// What one job of the service has.
struct Share {
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
};

// Options of `tessera triangulate` that are no fields: input-list, a file whose lines would name files anywhere (its
// lines can be sent); standard input; resume, a request of its own; config, quiet, json and verbose, which say how a
// command reads and prints. A file as crs is refused, its content is taken. Threads and memory are at most the share.
// Inputs and output are left to the caller. Error usage, here and below, with options marked.
Result<JobOptions> job_options(const proto::TriangulateInputs& inputs, const Share& share);
// Those that info has, too.
Result<proto::TriangulateInputs> cloud_of(const proto::InfoInputs& inputs);
// `scratch` is not asked for: it is the service's.
Result<VerifyOptions> verify_options(const proto::VerifyInputs& inputs, const Share& share);
Result<ExportOptions> export_options(const proto::ExportInputs& inputs);

// "memory: 4.00 GiB asked for, a job has 1.00 GiB here; ...", options marked; empty when nothing beyond the share is
// asked for. What is asked for are bounds: less than that is no other result, so that the job is taken, and told.
std::string beyond_share(const proto::Inputs& inputs, const Share& share);

std::vector<std::string> list_of(const google::protobuf::RepeatedPtrField<std::string>& texts);

}  // namespace tessera
