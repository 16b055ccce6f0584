// What `tessera info` prints, for input files and for result folders.
#pragma once

#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/job/job_options.h"

namespace tessera {

Result<std::string> describe_inputs(const std::vector<std::string>& inputs, JobOptions options, bool json);
Result<std::string> describe_result(const std::string& folder, bool json);

}  // namespace tessera
