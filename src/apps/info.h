// What `tessera info` prints, for input files and for result folders.
#pragma once

#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/job/job_options.h"

namespace tessera {

Result<std::string> describe_inputs(const std::vector<std::string>& inputs, JobOptions options, bool json);
Result<std::string> describe_result(const std::string& folder, bool json);

// The name in a WKT: `PROJCS["RGF93 v1 / Lambert-93",...` is "RGF93 v1 / Lambert-93". Other texts are left as they are.
std::string crs_name(const std::string& crs);

}  // namespace tessera
