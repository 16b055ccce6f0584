// A process that only works for a cluster: no API, no jobs of its own, but health and figures.
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

namespace tessera {

// The folder of tiles not in memory, for this process alone; what an earlier one has left in it goes. Errors: usage
// when another process has it; io.
Result<FolderLock> take_scratch(const std::filesystem::path& scratch);

// Works until it is drained (success), which SIGTERM and SIGINT ask for, too, and then for no longer than the cluster's
// drain_timeout; or until the others count it as lost: `begin_anew`, which should not return, unless it was to end.
// REQUIRES: its scratch is taken, and `words` are kept there. Of `http` the listeners for operations are its own.
// Errors as of Engine::join() and Server::start().
Status serve_node(const ServiceOptions& options, http::ServerOptions http, LastWords& words,
                  const std::function<void()>& begin_anew);

}  // namespace tessera
