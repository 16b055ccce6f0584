// A job of a daemon, watched as if it ran here: the same progress, summary and exit statuses.
#pragma once

#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/job/report/progress_display.h"
#include "src/service/client/server.h"

namespace tessera {

// "tessera watch ID", with the server when a flag named it: what can be typed as it stands.
std::string command_for(const Settings& settings, const std::string& verb, const std::string& id);

// How the display on this terminal looks.
ProgressStyle progress_style(const OutputOptions& output);

// Tells that the job is there, for those who do not watch it.
void print_detached(const Settings& settings, const proto::StatusInfo& job, const OutputOptions& output);

// Shows the job until it is successful. Errors: what made it fail, with its cause; interrupted when it was cancelled,
// and when Ctrl-C ends the watching, which leaves the job alone and says how to look again; those of Server.
Result<proto::StatusInfo> await_job(Server& server, const Settings& settings, const std::string& id,
                                    const OutputOptions& output, const std::stop_token& stop);
// The same, and then what came of it.
Status watch_job(Server& server, const Settings& settings, const std::string& id, const OutputOptions& output);

}  // namespace tessera
