// Errors as RFC 9457 problems.
#pragma once

#include <string>
#include <string_view>

#include "service.pb.h"
#include "src/base/result.h"

namespace tessera {

// What an option of the command is called in the messages of proto/service.proto: an OptionName (src/base/option.h).
std::string field_name(std::string_view key, std::string_view value);

// `detail`: a sentence; its options are named as fields.
proto::Problem problem(int status, std::string_view detail, Errc cause = Errc::ok);
// With the HTTP status that belongs to the code: usage 400, bad_input and memory 422, io 500, or 507 when the disk is
// full, interrupted 410, all else 500.
proto::Problem problem_of(const Error& error);
// The same of an error about inputs that a caller has named: what cannot be found or read is 422, no fault of ours.
// Of a process that is asked for an answer at once, and would take too long.
proto::Problem needs_a_job(const std::string& what);
proto::Problem problem_of_inputs(const Error& error);

// With the types that OGC API - Processes gives them.
proto::Problem no_such_job(std::string_view id);
proto::Problem result_not_ready(std::string_view id, std::string_view state);

}  // namespace tessera
