// What the processes have in common: what they are called, and what they make of which result.
#pragma once

#include <optional>
#include <string>

#include "service.pb.h"

namespace tessera {

// "triangulate", ...; empty when there are no inputs.
std::string process_of(const proto::Inputs& inputs);

// Whether it makes a result, whose name is `output`.
bool makes_result(const proto::Inputs& inputs);
// Of one that does: the name that is asked for; may be empty.
std::string result_output(const proto::Inputs& inputs);
// Of one that makes a file below a result's exports: its name there.
std::optional<std::string> export_output(const proto::Inputs& inputs);
// The result that is read; empty for those that read none.
std::string result_read(const proto::Inputs& inputs);
// Whether what stands in its place may be replaced.
bool overwrites(const proto::Inputs& inputs);

}  // namespace tessera
