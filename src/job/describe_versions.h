// Describes the versions of a result, as `tessera log` prints them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

// A table with a line for each version, or one object and a line end, for programs. Errors: those of tell_versions().
Result<std::string> describe_versions(const std::string& folder, bool json);
// The same object for a result that its readers know as `name`.
Result<std::string> describe_versions_of(const std::string& folder, const std::string& name);
// The table of such an object; nothing when it is something else.
std::optional<std::string> versions_text(const nlohmann::ordered_json& told);

}  // namespace tessera
