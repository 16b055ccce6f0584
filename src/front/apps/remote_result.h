// The commands verify, measure, export and info, done by a daemon.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/job/describe.h"
#include "src/result/export/export.h"
#include "src/service/client/server.h"

namespace tessera::apps {

// `name`: of the result; slashes at its end are ignored. Errors: those of watch_job().
Status verify_remotely(Settings& settings, const std::string& name, const OutputOptions& output);
Status measure_remotely(Settings& settings, const std::string& name, const OutputOptions& output);

// Downloads the files to `target`. They stay at the daemon only with --detach, and are then not downloaded.
Status export_remotely(Settings& settings, const std::string& name, const std::filesystem::path& target,
                       const ExportOptions& options, const OutputOptions& output);
// Downloads the files of a successful export job to `target`, replaces existing files there, and prints the outcome.
// `asked`: the name that the job was told to use, if it is known. `format`: the format that the user asked for, or
// empty.
Status fetch_export(client::Server& server, const proto::StatusInfo& job, const std::string& asked,
                    const ExportTarget& target, const std::string& format, const std::string& limits,
                    const OutputOptions& output, const std::stop_token& stop);

// `what`: one result of the daemon, or inputs below its folders.
Status info_remotely(Settings& settings, const std::vector<std::string>& what, const DescribeOptions& how);

}  // namespace tessera::apps
