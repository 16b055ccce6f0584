// The commands update and log, done by a daemon.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"

namespace tessera::apps {

// "A..B", of finite numbers, the second not below the first. Error usage.
Result<std::pair<double, double>> parse_times(const std::string& text);

struct RemoteUpdate {
  std::string name;                   // of the result
  std::vector<std::string> add;       // files of the daemon
  std::vector<std::string> polygons;  // files here
  std::vector<std::string> inputs;    // files of the daemon
};
// Lists of source indices and polygons are read here, and sent with the request. Errors: those of watch_job().
Status update_remotely(Settings& settings, const RemoteUpdate& update, const OutputOptions& output);

Status log_remotely(Settings& settings, const std::string& name, bool json);

}  // namespace tessera::apps
