// The command hag, done by a daemon.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/service/client/server.h"

namespace tessera::apps {

// `inputs` are files of the daemon. Downloads the copies into `folder`. They stay at the daemon only with --detach, and
// are then not downloaded. Error usage also when --ground does not name the ground.
Status hag_remotely(Settings& settings, const std::vector<std::string>& inputs, const std::filesystem::path& folder,
                    const OutputOptions& output);
// Downloads the copies of a successful hag job into `folder`, and prints the outcome. Error usage when a file exists
// there already, unless `overwrite`.
Status fetch_heights(client::Server& server, const proto::StatusInfo& job, const std::filesystem::path& folder,
                     bool overwrite, const OutputOptions& output, const std::stop_token& stop);

}  // namespace tessera::apps
