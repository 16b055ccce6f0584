// Who but the daemon's user may look into its data folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

// A sentence for the log; nothing when nobody else may, or there is no folder yet: tesserad makes it for its user
// alone. One that is there keeps its rights, for whoever gave it others may have meant them. The group of the daemon
// itself may enter: volumes of Kubernetes are its. Error io.
Result<std::optional<std::string>> who_else_may_enter(const std::filesystem::path& data);

}  // namespace tessera
