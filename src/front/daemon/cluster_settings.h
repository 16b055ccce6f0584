// The options of `tesserad` that make it a process of a cluster.
#pragma once

#include <filesystem>
#include <optional>

#include "src/base/result.h"
#include "src/cluster/cluster_options.h"
#include "src/front/apps/settings.h"

namespace CLI {
class App;
}

namespace tessera {

void add_cluster_options(CLI::App& app, Settings& settings);
// None: it is to be alone. Error usage names the source and what is wrong; io, usage for certificates.
Result<std::optional<ClusterOptions>> read_cluster_options(const Settings& settings, const std::filesystem::path& data);

}  // namespace tessera
