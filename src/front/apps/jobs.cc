// tessera jobs, job and cancel: list, show and cancel the jobs of a daemon.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/job_text.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/watching.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

constexpr const char* states = "accepted, running, successful, failed, dismissed";

Status run_jobs(Settings& settings) {
  BOOST_OUTCOME_TRY(state, settings.get("status", [](const std::string& text) { return parse_names(text); }));
  BOOST_OUTCOME_TRY(limit,
                    settings.get("limit", [](const std::string& text) { return parse_integer(text, 1, 1'000'000); }));
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(jobs, server.jobs(state.value_or(std::vector<std::string>{}),
                                      static_cast<std::size_t>(limit.value_or(100)), interrupt.token()));
  if (!json) say("%s", jobs_text(jobs).c_str());
  if (json) {
    for (const auto& job : jobs) print_json_line(job_json(job));
  }
  return success();
}

Status run_job(Settings& settings, const std::string& id) {
  if (id.empty()) return error(Errc::usage, "no job is given; 'tessera jobs' lists them");
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(job, server.job(id, interrupt.token()));
  if (json) {
    print_json_line(job_json(job));
  } else {
    say("%s", job_text(job).c_str());
  }
  return success();
}

Status run_cancel(Settings& settings, const std::string& id) {
  if (id.empty()) return error(Errc::usage, "no job is given; 'tessera jobs' lists them");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  // For a job that has ended, the request below would make the daemon forget the job.
  BOOST_OUTCOME_TRY(job, server.job(id, interrupt.token()));
  if (has_ended(job)) return error(Errc::usage, "job " + id + " has ended already: " + job.status());
  BOOST_OUTCOME_TRY(cancelled, server.dismiss(id, interrupt.token()));
  if (output.json) {
    print_json_line(job_json(cancelled));
  } else if (!output.quiet) {
    say("job %s is cancelled; %s continues it\n", id.c_str(), command_for(settings, "resume", id).c_str());
  }
  return success();
}

}  // namespace

std::shared_ptr<std::string> add_job_id(Command& command) {
  auto id = std::make_shared<std::string>();
  add_argument(command, "job", "ID", *id, "the job's id, as 'tessera jobs' shows it");
  return id;
}

Command add_jobs(CLI::App& root) {
  auto command = new_command(root, "jobs", "Lists the jobs of a daemon",
                             "  tessera jobs --server http://127.0.0.1:7070\n"
                             "  tessera jobs --status accepted,running      (with TESSERA_SERVER set)\n"
                             "  tessera jobs --limit 1000 --json");
  set_group(command, daemon_group);
  add_value(command, "status", "LIST", std::string("show only jobs in these states: ") + states);
  add_choices(command, "status", states);
  add_value(command, "limit", "N", "show at most this many jobs; default: 100");
  add_server_options(command);
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
  command.run = [settings = command.settings.get()](const std::vector<std::string>&) { return run_jobs(*settings); };
  return command;
}

Command add_job(CLI::App& root) {
  auto command = new_command(root, "job", "Tells what a daemon knows of a job",
                             "  tessera job ID --server http://127.0.0.1:7070\n"
                             "  tessera job ID --json");
  set_group(command, daemon_group);
  add_server_options(command);
  add_switch(command, "json", "one JSON object on stdout, instead of text");
  command.run = [settings = command.settings.get(), id = add_job_id(command)](const std::vector<std::string>&) {
    return run_job(*settings, *id);
  };
  return command;
}

Command add_cancel(CLI::App& root) {
  auto command = new_command(root, "cancel", "Stops a job of a daemon, so that it can be resumed",
                             "  tessera cancel ID --server http://127.0.0.1:7070\n"
                             "  tessera cancel ID --quiet");
  set_group(command, daemon_group);
  add_server_options(command);
  add_output_switches(command);
  command.run = [settings = command.settings.get(), id = add_job_id(command)](const std::vector<std::string>&) {
    return run_cancel(*settings, *id);
  };
  return command;
}

}  // namespace tessera::apps
