// How a command finds the daemon it asks: --server, a token, TLS.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/service/client/server.h"

namespace tessera {

void add_server_options(Command& command);
// The same, and --detach, of a command that can also do without a daemon.
void add_remote_options(Command& command);
// Error usage for --detach of a job that no daemon does.
Status refuse_detach(const Settings& settings);
// Whether one is named, by a flag, TESSERA_SERVER or the file.
bool names_server(const Settings& settings);
// Error usage when none is named, or something is wrong with what is; io when the token's file cannot be read.
Result<Server> open_server(Settings& settings);

// One object on a line of stdout.
void print_json_line(const nlohmann::ordered_json& object);

}  // namespace tessera
