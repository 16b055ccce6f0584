// A process that only works for a cluster. It has no API and no jobs of its own, but health checks and metrics.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "src/base/files/folder_lock.h"
#include "src/base/result.h"
#include "src/cluster/cluster_options.h"
#include "src/front/daemon/last_words.h"
#include "src/service/http/server.h"
#include "src/service/service.h"

namespace tessera::daemon {

// Takes the folder for tiles that are not in memory, for this process alone, and removes what earlier processes have
// left there. Errors: usage if another process has the folder; io.
Result<FolderLock> take_scratch(const std::filesystem::path& scratch);

// Works until the node is drained, and returns success. SIGTERM and SIGINT ask for that, too; then the process ends
// after the cluster's drain_timeout at the latest. If the others count the node as lost and it may come back, calls
// `begin_anew`, which should not return; but not after SIGTERM or SIGINT.
// REQUIRES: the scratch folder is taken, and `words` are kept there. Only the listeners of `http` for operations are
// used. Errors: those of Engine::join() and Server::start().
Status serve_node(const service::ServiceOptions& options, service::http::ServerOptions http, LastWords& words,
                  const std::function<void()>& begin_anew);

}  // namespace tessera::daemon
