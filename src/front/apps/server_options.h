// The options with which a command finds its daemon: --server, a token, TLS.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/service/client/server.h"

namespace tessera::apps {

void add_server_options(Command& command);
// Adds the same options and --detach, for a command that can also work without a daemon.
void add_remote_options(Command& command);
// Error usage if --detach is given. For jobs that this process does.
Status refuse_detach(const Settings& settings);
// Returns whether a flag, TESSERA_SERVER or the configuration file names a server.
bool names_server(const Settings& settings);
// Error usage if no server is named, or an option is wrong; io if the token's file cannot be read.
Result<client::Server> open_server(Settings& settings);

// Prints one object as a line of stdout.
void print_json_line(const nlohmann::ordered_json& object);

}  // namespace tessera::apps
