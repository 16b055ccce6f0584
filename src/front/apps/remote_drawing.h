// The commands region, dem and contours, done by a daemon.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/service/client/server.h"

namespace tessera::apps {

struct RemoteRegion {
  std::vector<std::string> inputs;
  std::string name;  // of the result at the daemon
  std::string crs;   // empty: the system of the files
};
Status region_remotely(Settings& settings, const RemoteRegion& region, const OutputOptions& output);

// `process`: dem or contours. Downloads the file to `target`. The file stays at the daemon only with --detach, and is
// then not downloaded.
Status draw_remotely(Settings& settings, const std::string& process, const std::string& result,
                     const std::filesystem::path& target, const OutputOptions& output);

bool is_drawing(const proto::StatusInfo& job);
// Downloads the file of a successful dem or contours job to `target`, replaces an existing file there, and prints the
// outcome.
Status fetch_drawing(client::Server& server, const proto::StatusInfo& job, const std::filesystem::path& target,
                     const OutputOptions& output, const std::stop_token& stop);

}  // namespace tessera::apps
