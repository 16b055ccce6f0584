// What `tessera info` prints, for input files and for result folders.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/job/job_options.h"

namespace tessera {

struct Described {
  std::string text = {};
  std::optional<Error> error = {};  // of inputs that could not be described, or not together with the others
};

// `statistics`: all points are read.
Described describe_inputs(const std::vector<std::string>& inputs, JobOptions options, bool json, bool statistics);
Result<std::string> describe_result(const std::string& folder, bool json);

}  // namespace tessera
