// The options of `tesserad`: flags, TESSERAD_* variables, a TOML file (config/tesserad.toml).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/settings.h"
#include "src/service/http/server.h"
#include "src/service/service.h"

namespace CLI {
class App;
}

namespace tessera {

// Where and as what it takes part in a cluster: the rest of ClusterOptions follows from where it runs.
struct DaemonOptions {
  ServiceOptions service;  // its cluster included, also when this process only works for one
  http::ServerOptions http;
  bool json_log = false;
  bool print_token = false;  // also where it is no terminal that reads it
};

// What the sources say, as text, until all have been asked.
struct DaemonSettings {
  Settings top{"", "TESSERAD_"};
  Settings limits{"limits", "TESSERAD_LIMITS_"};
};

void add_daemon_options(CLI::App& app, DaemonSettings& settings);
// Reads environment and file, too. Error usage names the source and what is wrong.
Result<DaemonOptions> read_daemon_options(DaemonSettings& settings,
                                          const std::function<const char*(const char*)>& get_environment);

// "127.0.0.1:7070", "[::1]:7070", "7070" for the loopback.
Result<http::ListenOptions> parse_listen_address(std::string_view text);
// Seconds: "90", "90s", "15m", "12h", "30d"; "forever" is 0.
Result<std::uint64_t> parse_duration(std::string_view text);

}  // namespace tessera
