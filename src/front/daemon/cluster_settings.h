// The options of `tesserad` that make it a member of a cluster.
#pragma once

#include <filesystem>
#include <optional>

#include "src/base/result.h"
#include "src/cluster/cluster_options.h"
#include "src/front/apps/settings.h"

namespace CLI {
class App;
}

namespace tessera::daemon {

void add_cluster_options(CLI::App& app, apps::Settings& settings);
// Returns the options; no value if the daemon is to work alone. Errors: usage, with the source and the reason; io and
// usage for certificates.
Result<std::optional<ClusterOptions>> read_cluster_options(const apps::Settings& settings,
                                                           const std::filesystem::path& data);

}  // namespace tessera::daemon
