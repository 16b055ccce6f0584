#include "src/front/apps/remote_heights.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
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
#include "src/service/client/written.h"

namespace tessera::apps {

namespace fs = std::filesystem;

namespace {

Error no_answer(const client::Server& server) {
  return error(Errc::io, server.address().text() + ": the server's answer is not what was asked for");
}

Result<nlohmann::ordered_json> inputs_of(const Settings& settings, const std::vector<std::string>& inputs) {
  if (std::find(inputs.begin(), inputs.end(), "-") != inputs.end())
    return error(Errc::usage, "standard input cannot be sent to a daemon; save it in a file below one of its folders");
  const auto ground = settings.text("ground");
  if (!ground)
    return error(Errc::usage,
                 "a daemon needs the ground as one of its results: 'tessera triangulate FILE... -o ground --dim 2 "
                 "--class 2' makes it; then add --ground ground");
  BOOST_OUTCOME_TRY(json, remote_inputs(settings, *proto::HagInputs::descriptor(), only_here({"ground"})));
  json["inputs"] = inputs;
  json["triangulation"] = without_slash(*ground);
  return std::move(json);
}

}  // namespace

Status hag_remotely(Settings& settings, const std::vector<std::string>& inputs, const fs::path& folder,
                    const OutputOptions& output) {
  BOOST_OUTCOME_TRY(json, inputs_of(settings, inputs));
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  // Files that do not stay get a unique name, so that they cannot replace files of another user of the daemon.
  const fs::path name = fs::absolute(without_slash(folder.string())).lexically_normal().filename();
  const std::string made = detach ? name.stem().string() : client::new_idempotency_key();
  json["output"] = made;
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  const auto submitted = server.submit("hag", json, client::new_idempotency_key(), interrupt.token());
  if (!submitted && submitted.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; 'tessera jobs' tells whether the daemon has the job");
  if (!submitted)
    return advise_here(advise_upload(submitted.error(), inputs), json["triangulation"].get<std::string>());
  const auto& job = submitted.value();
  if (detach) {
    print_detached(settings, job, output);
    return success();
  }
  const auto done = await_job(server, settings, job.job_id(), output, interrupt.token());
  const Status fetched =
      done ? fetch_heights(server, done.value(), folder, overwrite, output, interrupt.token()) : Status(done.error());
  if (!fetched) {
    Error failed = fetched.error();
    if (done || failed.code == Errc::interrupted)
      failed.where += "; " + command_for(settings, "fetch", job.job_id() + " -o " + folder.string()) +
                      " fetches what the job makes";
    return failed;
  }
  const auto removed = server.remove_export(done.value().triangulation(), made, interrupt.token());
  if (!removed)
    say_beside("note: the daemon could not remove its copy of the files: %s\n",
               in_plain_words(removed.error().where).c_str());
  return success();
}

Status fetch_heights(client::Server& server, const proto::StatusInfo& job, const fs::path& folder, bool overwrite,
                     const OutputOptions& output, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(outcome, server.outcome(job.job_id(), stop));
  auto heights = heights_of(outcome);
  const auto made = outcome.find("output");
  if (!heights || made == outcome.end() || !made->is_string()) return no_answer(server);
  BOOST_OUTCOME_TRY(files, client::written_files(outcome));
  BOOST_OUTCOME_TRY(places, client::places_in_folder(files, made->get<std::string>(), folder));
  for (const auto& place : places) {
    BOOST_OUTCOME_TRY(there, is_there(place));
    if (there && !overwrite)
      return error(Errc::usage, place.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
  }
  const auto fetched =
      client::fetch_written(server, job.triangulation(), files, places, percent_line("fetching", output), stop);
  clear_line(output);
  BOOST_OUTCOME_TRYV(fetched);
  for (auto& file : *heights) file.to = folder / file.to.filename();
  print_heights(folder.string(), *heights, std::nullopt, output);
  return success();
}

}  // namespace tessera::apps
