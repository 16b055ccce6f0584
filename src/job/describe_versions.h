// Describes the versions of a result, as `tessera log` prints them.
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera {

// A table with a line for each version, or one object and a line end, for programs. Errors: those of tell_versions().
Result<std::string> describe_versions(const std::string& folder, bool json);

}  // namespace tessera
