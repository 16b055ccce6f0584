// The options of `tesserad`: flags, TESSERAD_* variables, a TOML file (config/tesserad.toml).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/settings.h"
#include "src/input/remote/remote_objects.h"
#include "src/service/http/server.h"
#include "src/service/service.h"

namespace CLI {
class App;
}

namespace tessera::daemon {

struct DaemonOptions {
  service::ServiceOptions service;  // with the options of the cluster, also for a process that only works for a cluster
  service::http::ServerOptions http;
  std::optional<remote::RemoteOptions> remote;  // how inputs are read by their addresses; nothing: they are not
  bool hdf5 = false;                            // inputs in HDF5 are read
  bool json_log = false;
  bool print_token = false;  // print the token also if stdout is no terminal
};

// The text that the sources have for each option.
struct DaemonSettings {
  apps::Settings top{"", "TESSERAD_"};
  apps::Settings limits{"limits", "TESSERAD_LIMITS_"};
};

void add_daemon_options(CLI::App& app, DaemonSettings& settings);
// Returns the checked options, from flags, environment and file. Error usage, with the source and the reason.
Result<DaemonOptions> read_daemon_options(DaemonSettings& settings,
                                          const std::function<const char*(const char*)>& get_environment);

// Parses "127.0.0.1:7070", "[::1]:7070", or "7070", which is on the loopback. Error usage.
Result<service::http::ListenOptions> parse_listen_address(std::string_view text);
// Parses "90", "90s", "15m", "12h", "30d"; "forever" is 0. Returns seconds. Error usage.
Result<std::uint64_t> parse_duration(std::string_view text);

}  // namespace tessera::daemon
