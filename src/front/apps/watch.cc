// tessera watch and resume: show a job of a daemon as if it ran here, and continue one.
#include <memory>
#include <string>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/watching.h"

namespace tessera::apps {
namespace {

Result<proto::StatusInfo> resume(client::Server& server, const std::string& id) {
  const Interrupt interrupt;
  return server.resume(id, interrupt.token());
}

Status run_watch(Settings& settings, const std::string& id, bool resuming) {
  if (id.empty()) return error(Errc::usage, "no job is given; 'tessera jobs' lists them");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  if (output.verbose) log_everything();
  if (resuming) {
    BOOST_OUTCOME_TRY(job, resume(server, id));
    if (detach) {
      print_detached(settings, job, output);
      return success();
    }
  }
  return watch_job(server, settings, id, output);
}

}  // namespace

Command add_watch(CLI::App& root) {
  auto command =
      new_command(root, "watch", "Shows the progress of a job of a daemon, and its summary",
                  "  tessera watch ID --server http://127.0.0.1:7070\n"
                  "  tessera watch ID --json\n\n"
                  "The exit status is that of the job. Ctrl-C ends the watching, not the job. If the daemon goes\n"
                  "away, the command waits for it.");
  set_group(command, daemon_group);
  add_server_options(command);
  add_output_switches(command);
  command.run = [settings = command.settings.get(), id = add_job_id(command)](const std::vector<std::string>&) {
    return run_watch(*settings, *id, false);
  };
  return command;
}

Command add_resume(CLI::App& root) {
  auto command = new_command(root, "resume", "Continues a job of a daemon that failed or was cancelled",
                             "  tessera resume ID --server http://127.0.0.1:7070\n"
                             "  tessera resume ID --detach      (without watching it)");
  set_group(command, daemon_group);
  add_switch(command, "detach", "do not watch the job", 0, true);
  add_server_options(command);
  add_output_switches(command);
  command.run = [settings = command.settings.get(), id = add_job_id(command)](const std::vector<std::string>&) {
    return run_watch(*settings, *id, true);
  };
  return command;
}

}  // namespace tessera::apps
