#include "src/front/apps/remote_update.h"

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "src/base/option.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/remote_drawing.h"
#include "src/front/apps/remote_inputs.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/watching.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/npy/npy_header.h"
#include "src/job/arguments.h"
#include "src/job/describe_versions.h"
#include "src/service/client/server.h"

namespace tessera::apps {
namespace {

using UpdateJson = nlohmann::ordered_json;

Status refuse_what_is_here(const Settings& settings) {
  if (settings.source("wait") == Settings::Source::flag)
    return error(Errc::usage, "--wait is not for a job of a daemon, which refuses a change while another one is made");
  if (settings.source("resume") == Settings::Source::flag)
    return error(Errc::usage, "--resume is not for a job of a daemon: 'tessera resume JOB' continues it");
  return success();
}

Result<UpdateJson> inputs_of_update(const Settings& settings, const RemoteUpdate& update) {
  BOOST_OUTCOME_TRYV(refuse_what_is_here(settings));
  BOOST_OUTCOME_TRY(json, remote_inputs(settings, *proto::UpdateInputs::descriptor(),
                                        only_here({"remove-ids", "remove-time", "wait", "resume"})));
  json["triangulation"] = without_slash(update.name);
  if (const auto output = settings.text("output")) json["output"] = without_slash(*output);
  if (!update.add.empty()) json["inputs"] = update.add;
  if (!update.inputs.empty()) json["remove_input"] = update.inputs;
  const auto path = settings.text("remove-ids");
  if (path && path->starts_with("upload:")) {
    json["remove_ids_file"] = *path;
  } else if (path) {
    BOOST_OUTCOME_TRY(file, open_file(*path));
    BOOST_OUTCOME_TRY(ids, read_npy_integers(*file));
    json["remove_ids"] = ids;
  }
  BOOST_OUTCOME_TRY(times, settings.get("remove-time", parse_times));
  if (times) json["remove_time"] = {times->first, times->second};
  if (update.polygons.size() > 1)
    return error(Errc::usage, "--remove-polygon: a daemon takes one file, which may have many polygons, and " +
                                  std::to_string(update.polygons.size()) + " are given");
  if (!update.polygons.empty()) {
    BOOST_OUTCOME_TRY(text, polygons_for_daemon("remove-polygon", update.polygons.front()));
    json["remove_polygon"] = text;
  }
  return std::move(json);
}

}  // namespace

Result<std::pair<double, double>> parse_times(const std::string& text) {
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) return error(Errc::usage, "'" + text + "' is no interval of times like 100.5..200");
  BOOST_OUTCOME_TRY(from, parse_finite(text.substr(0, dots)));
  BOOST_OUTCOME_TRY(to, parse_finite(text.substr(dots + 2)));
  if (from <= to) return std::pair(from, to);
  return error(Errc::usage, "'" + text + "' is no interval of times: its end is before its begin");
}

Status update_remotely(Settings& settings, const RemoteUpdate& update, const OutputOptions& output) {
  BOOST_OUTCOME_TRY(inputs, inputs_of_update(settings, update));
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  proto::StatusInfo job;
  {
    const Interrupt interrupt;
    auto submitted = server.submit("update", inputs, client::new_idempotency_key(), interrupt.token());
    if (!submitted && submitted.error().code == Errc::interrupted)
      return error(Errc::interrupted, "interrupted; 'tessera jobs' tells whether the daemon has the job");
    if (!submitted) return advise_here(advise_upload(submitted.error(), update.add), update.name);
    job = std::move(submitted).value();
  }
  if (!detach) return watch_job(server, settings, job.job_id(), output);
  print_detached(settings, job, output);
  return success();
}

Status log_remotely(Settings& settings, const std::string& name, bool json) {
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  const auto told = server.versions(without_slash(name), interrupt.token());
  if (!told) return advise_here(told.error(), name);
  if (json) {
    print_json_line(told.value());
    return success();
  }
  const auto text = versions_text(told.value());
  if (!text) return error(Errc::io, server.address().text() + ": the server's answer is not what was asked for");
  say_whole(*text, false);
  return success();
}

}  // namespace tessera::apps
