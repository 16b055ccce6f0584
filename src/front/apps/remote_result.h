// verify, export and info, done by a daemon.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/job/describe.h"
#include "src/result/export/export.h"
#include "src/service/client/server.h"

namespace tessera {

// `name`: of the result, a slash behind it passed over. Errors as those of watch_job().
Status verify_remotely(Settings& settings, const std::string& name, const OutputOptions& output);

// The file arrives at `target`, and stays at the daemon only with --detach.
Status export_remotely(Settings& settings, const std::string& name, const std::filesystem::path& target,
                       const ExportOptions& options, const OutputOptions& output);
// What a successful export job has written, to `target`, which is then told; in place of what is there. `asked`: what
// the job was told to call it, if that is known; `format`: as it was asked for, or empty.
Status fetch_export(Server& server, const proto::StatusInfo& job, const std::string& asked, const ExportTarget& target,
                    const std::string& format, const std::optional<std::string>& max_edge, const OutputOptions& output,
                    const std::stop_token& stop);

// One result of the daemon, or inputs below its folders.
Status info_remotely(Settings& settings, const std::vector<std::string>& what, const DescribeOptions& how);

}  // namespace tessera
