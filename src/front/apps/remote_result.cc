#include "src/front/apps/remote_result.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/option.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/remote_inputs.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/watching.h"
#include "src/job/describe.h"
#include "src/service/client/written.h"

namespace tessera::apps {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

Error no_json(const client::Server& server) {
  return error(Errc::io, server.address().text() + ": the server's answer is not what was asked for");
}

Result<proto::StatusInfo> submit(client::Server& server, const char* process, const Json& inputs,
                                 const std::string& name, const std::stop_token& stop) {
  auto submitted = server.submit(process, inputs, client::new_idempotency_key(), stop);
  if (submitted) return submitted;
  if (submitted.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; 'tessera jobs' tells whether the daemon has the job");
  return advise_here(submitted.error(), name);
}

// Submits a job that works on a result at the daemon, and watches it unless --detach is given.
Status work_remotely(Settings& settings, const char* process, Json inputs, const std::string& name,
                     const OutputOptions& output) {
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  inputs["triangulation"] = without_slash(name);
  BOOST_OUTCOME_TRY(server, open_server(settings));
  proto::StatusInfo job;
  {
    const Interrupt interrupt;
    BOOST_OUTCOME_TRY(submitted, submit(server, process, inputs, name, interrupt.token()));
    job = std::move(submitted);
  }
  if (!detach) return watch_job(server, settings, job.job_id(), output);
  print_detached(settings, job, output);
  return success();
}

}  // namespace

Status verify_remotely(Settings& settings, const std::string& name, const OutputOptions& output) {
  if (settings.source("scratch") == Settings::Source::flag)
    return error(Errc::usage, "--scratch is not for a job of a daemon, which has its data folder");
  BOOST_OUTCOME_TRY(inputs, remote_inputs(settings, *proto::VerifyInputs::descriptor(), only_here({"scratch"})));
  return work_remotely(settings, "verify", std::move(inputs), name, output);
}

Status measure_remotely(Settings& settings, const std::string& name, const OutputOptions& output) {
  BOOST_OUTCOME_TRY(inputs, remote_inputs(settings, *proto::MeasureInputs::descriptor(), only_here({})));
  return work_remotely(settings, "measure", std::move(inputs), name, output);
}

Status fetch_export(client::Server& server, const proto::StatusInfo& job, const std::string& asked,
                    const ExportTarget& target, const std::string& format, const std::string& limits,
                    const OutputOptions& output, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(outcome, server.outcome(job.job_id(), stop));
  auto exported = exported_of(outcome);
  if (!exported) return no_json(server);
  BOOST_OUTCOME_TRY(files, client::written_files(outcome));
  const std::string made = exported->path;
  if (!asked.empty() && made != asked) return no_json(server);
  BOOST_OUTCOME_TRY(places, target.folder
                                ? client::places_in_folder(files, made, target.path)
                                : client::places_beside(files, made, target.path, export_endings(target.path, format)));
  const auto fetched =
      client::fetch_written(server, job.triangulation(), files, places, percent_line("fetching", output), stop);
  clear_line(output);
  BOOST_OUTCOME_TRYV(fetched);
  exported->path = target.path;
  print_exported(*exported, limits, output);
  return success();
}

Status export_remotely(Settings& settings, const std::string& name, const fs::path& path, const ExportOptions& options,
                       const OutputOptions& output) {
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  BOOST_OUTCOME_TRY(target, find_export_target(path, options));
  const auto beside = target.path.has_parent_path() ? target.path.parent_path() : fs::path(".");
  BOOST_OUTCOME_TRY(place, is_folder(beside));
  if (!detach && !place) return error(Errc::io, beside.string() + ": there is no such folder");
  BOOST_OUTCOME_TRY(inputs, remote_inputs(settings, *proto::ExportInputs::descriptor(), only_here({})));
  inputs["triangulation"] = without_slash(name);
  auto file = fs::absolute(target.path).lexically_normal().filename();
  // For the daemon a name without an ending is a folder, and a name with an ending a file.
  if (target.folder) file.replace_extension();
  inputs["output"] = file.string();
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(submitted, submit(server, "export", inputs, name, interrupt.token()));
  if (detach) {
    print_detached(settings, submitted, output);
    return success();
  }
  const auto with_advice = [&](Error failed) {
    if (failed.code == Errc::interrupted)
      failed.where += "; " + command_for(settings, "fetch", submitted.job_id() + " -o " + path.string()) +
                      " fetches what the job makes";
    return failed;
  };
  const auto done = await_job(server, settings, submitted.job_id(), output, interrupt.token());
  if (!done) return with_advice(done.error());
  const auto fetched = fetch_export(server, done.value(), file.string(), target, options.format, limits_text(settings),
                                    output, interrupt.token());
  if (!fetched) return with_advice(fetched.error());
  const auto removed = server.remove_export(done.value().triangulation(), file.string(), interrupt.token());
  if (!removed)
    say_beside("note: the daemon could not remove its copy of the export: %s\n",
               in_plain_words(removed.error().where).c_str());
  return success();
}

Status info_remotely(Settings& settings, const std::vector<std::string>& what, const DescribeOptions& how) {
  if (std::find(what.begin(), what.end(), "-") != what.end())
    return error(Errc::usage, "standard input cannot be sent to a daemon; save it in a file below one of its folders");
  if (settings.text("input-list").has_value())
    return error(Errc::usage,
                 "--input-list is not for a job of a daemon: name the daemon's files, folders or patterns");
  BOOST_OUTCOME_TRY(inputs, remote_inputs(settings, *proto::InfoInputs::descriptor(), only_here({})));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  const auto name = without_slash(what.front());
  std::optional<proto::TriangulationInfo> result;
  if (what.size() == 1 && name.find('/') == std::string::npos) {
    BOOST_OUTCOME_TRY(found, server.triangulation(name, interrupt.token()));
    result = std::move(found);
  }
  if (result) {
    inputs = {{"triangulation", name}};
  } else {
    inputs["inputs"] = what;
  }
  auto told = server.info(inputs, interrupt.token());
  if (!told) return advise_upload(told.error(), what);
  Json described = std::move(told.value().now);
  if (told.value().job) {
    const OutputOptions silent{.quiet = true};
    BOOST_OUTCOME_TRY(job, await_job(server, settings, told.value().job->job_id(), silent, interrupt.token()));
    BOOST_OUTCOME_TRY(found, server.outcome(job.job_id(), interrupt.token()));
    described = std::move(found);
  }
  // The path of a result at the daemon means nothing here, so its name replaces it.
  if (result) described["result"] = name;
  if (how.json) {
    print_json_line(described);
    return success();
  }
  const auto text = description_text(described, how.counters);
  if (!text) return no_json(server);
  say_whole(*text, false);
  return success();
}

}  // namespace tessera::apps
