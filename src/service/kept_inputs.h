// How much of what a job was asked to do is kept, and for how long: records of jobs are in memory, and outlive them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "job_record.pb.h"

namespace tessera {

// Bytes of the inputs of a job, as protobuf; of those of all jobs of a caller that wait or run; and of those of all
// that have ended: beyond it jobs are forgotten as beyond their number.
inline constexpr std::uint64_t inputs_bytes_max = 256 << 10;
inline constexpr std::uint64_t inputs_of_caller_bytes_max = 64 << 20;

// The problem of inputs that are too large to be kept: 413.
std::optional<proto::Problem> check_size(const proto::Inputs& inputs);

// The same for the same inputs, and for no others.
std::string sum_of(const proto::Inputs& inputs);
// Whether the job was asked for these inputs, also when its own were dropped.
bool same_inputs(const proto::JobRecord& job, const proto::Inputs& inputs);

// Of a job that will not be begun again: lists and long texts go, names of what it read and made stay.
void drop_inputs(proto::JobRecord& job);

}  // namespace tessera
