// Converts errors to RFC 9457 problems.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "service.pb.h"
#include "src/base/result.h"

namespace tessera::service {

// The name of a command's option in the messages of proto/service.proto: an OptionName (src/base/option.h).
std::string field_name(std::string_view key, std::string_view value);

// `detail` is a sentence, in which options get the names of fields.
proto::Problem problem(int status, std::string_view detail, Errc cause = Errc::ok);
// A problem with the HTTP status of the error's code: usage 400, bad_input and memory 422, interrupted 410, io 507 when
// the disk is full, all others 500.
proto::Problem problem_of(const Error& error);
// The problem of a result's error; nothing when there is none.
template <class T>
std::optional<proto::Problem> problem_if(const Result<T>& result) {
  return result ? std::nullopt : std::optional(problem_of(result.error()));
}
// The problem of a process that is asked for an answer at once and would take too long.
proto::Problem needs_a_job(const std::string& what);
// As problem_of(), for an error about inputs that a caller has named: an input that is missing or cannot be read is
// 422, because the service is not at fault.
proto::Problem problem_of_inputs(const Error& error);

// The problem with each of its sentences replaced by `how(sentence)`.
proto::Problem reworded(proto::Problem problem, const std::function<std::string(const std::string&)>& how);

// Problems with the types that OGC API - Processes defines.
proto::Problem no_such_job(std::string_view id);
proto::Problem result_not_ready(std::string_view id, std::string_view state);

}  // namespace tessera::service
