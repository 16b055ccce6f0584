// Watches a job of a daemon. Progress, summary and exit status are those of a job that runs here.
#pragma once

#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/job/report/progress_display.h"
#include "src/service/client/server.h"

namespace tessera::apps {

// Returns a command that the user can type, as 'tessera watch ID' in quotes, with --server if a flag named the server.
std::string command_for(const Settings& settings, const std::string& verb, const std::string& id);

// Returns the style in which progress is shown on this terminal.
ProgressStyle progress_style(const OutputOptions& output);

// Prints that the job was submitted, for --detach.
void print_detached(const Settings& settings, const proto::StatusInfo& job, const OutputOptions& output);

// Shows the job's progress until the job is successful. Errors: that of a job that fails; interrupted if the job was
// cancelled, and if Ctrl-C ends the watching, which does not end the job (the message says how to watch again); those
// of Server.
Result<proto::StatusInfo> await_job(client::Server& server, const Settings& settings, const std::string& id,
                                    const OutputOptions& output, const std::stop_token& stop);
// Does the same, and then prints the outcome of the job.
Status watch_job(client::Server& server, const Settings& settings, const std::string& id, const OutputOptions& output);

}  // namespace tessera::apps
