// What the processes have in common: their names, what they make, and which result they read.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "service.pb.h"

namespace tessera::service {

// The process of the inputs: "triangulate", ...; empty when there are no inputs.
std::string process_of(const proto::Inputs& inputs);

// True if the process makes a result, which is named `output`.
bool makes_result(const proto::Inputs& inputs);
// True if the process makes a new version of the result that it reads.
bool changes_result(const proto::Inputs& inputs);
// The requested name of the result that the process makes; may be empty.
std::string result_output(const proto::Inputs& inputs);
// The name of the file that the process makes below a result's exports, if it makes one.
std::optional<std::string> export_output(const proto::Inputs& inputs);
// The name of the result that the process reads; empty if it reads none.
std::string result_read(const proto::Inputs& inputs);
// The name of a result that the process reads beside the one that it works on: that of result_read(), or of the result
// that it makes. Empty if there is none.
std::string second_result_read(const proto::Inputs& inputs);
// The version of result_read() that is read; 0: the newest.
std::uint32_t version_read(const proto::Inputs& inputs);
// True if the output may replace an existing one.
bool overwrites(const proto::Inputs& inputs);

}  // namespace tessera::service
