// What `tessera info` prints, for input files and for result folders.
#pragma once

#include <string>

#include "src/apps/triangulate_options.h"
#include "src/base/result.h"

namespace tessera {

Result<std::string> describe_inputs(TriangulateOptions options);
Result<std::string> describe_result(const std::string& folder, bool json);

}  // namespace tessera
