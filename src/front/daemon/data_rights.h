// Finds out which other users may enter the data folder of a daemon.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera::daemon {

// Returns a sentence for the log if other users may enter the folder; no value if none may, or if there is no folder
// yet (tesserad makes it for its user alone). An existing folder keeps its rights, because they may be intended. The
// daemon's own group may enter: volumes of Kubernetes belong to it. Error io.
Result<std::optional<std::string>> who_else_may_enter(const std::filesystem::path& data);

}  // namespace tessera::daemon
