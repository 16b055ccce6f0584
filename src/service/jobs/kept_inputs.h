// Limits how much of a job's inputs is kept, and for how long. Records of jobs are in memory, and outlive their jobs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "job_record.pb.h"

namespace tessera::service {

// Limits of the inputs' size as protobuf: of one job, and of all waiting and running jobs of a caller. For ended jobs
// the limit is also per caller: beyond it, jobs are forgotten as beyond their number.
inline constexpr std::uint64_t inputs_bytes_max = 256 << 10;
inline constexpr std::uint64_t inputs_of_caller_bytes_max = 64 << 20;

// The problem 413 when inputs are too large to be kept.
std::optional<proto::Problem> check_size(const proto::Inputs& inputs);

// A checksum that is equal for equal inputs, and for no others.
std::string sum_of(const proto::Inputs& inputs);
// True if the job was submitted with these inputs, also when its own inputs were dropped.
bool same_inputs(const proto::JobRecord& job, const proto::Inputs& inputs);

// Drops most inputs of a job that will not run again: lists and long texts. Names of what the job read and made stay.
void drop_inputs(proto::JobRecord& job);

}  // namespace tessera::service
