// The command region, and those that make a file of a result, done by a daemon.
#pragma once

#include <filesystem>
#include <map>
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

// What the daemon gets for options that name files here, and for arguments: text, by the name of the input.
using RemoteTexts = std::map<std::string, std::string>;
// The text of a file of polygons, which the option `key` names. Error usage if the file is no GeoJSON by its name; io.
Result<std::string> polygons_for_daemon(const std::string& key, const std::filesystem::path& file);

// `process`: dem, contours, voronoi, density, alpha or volume. Downloads the file to `target`. The file stays at the
// daemon only with --detach, and is then not downloaded.
Status draw_remotely(Settings& settings, const std::string& process, const std::string& result,
                     const std::filesystem::path& target, const OutputOptions& output, const RemoteTexts& texts = {});

bool is_drawing(const proto::StatusInfo& job);
// Downloads the file of a successful job of such a process to `target`, replaces an existing file there, and prints the
// outcome.
Status fetch_drawing(client::Server& server, const proto::StatusInfo& job, const std::filesystem::path& target,
                     const OutputOptions& output, const std::stop_token& stop);

}  // namespace tessera::apps
