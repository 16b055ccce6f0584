#include "src/front/apps/remote_drawing.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/front/apps/drawn.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/remote_inputs.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/watching.h"
#include "src/service/client/written.h"

namespace tessera::apps {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

Result<proto::StatusInfo> submit(client::Server& server, const std::string& process, const Json& inputs,
                                 const std::stop_token& stop) {
  auto submitted = server.submit(process, inputs, client::new_idempotency_key(), stop);
  if (!submitted && submitted.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; 'tessera jobs' tells whether the daemon has the job");
  return submitted;
}

Status check_target(const Settings& settings, const fs::path& target) {
  BOOST_OUTCOME_TRY(found, look_at(target));
  if (found && S_ISDIR(found->st_mode)) return error(Errc::usage, target.string() + ": is a folder");
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  if (found && !overwrite) return error(Errc::usage, target.string() + ": exists already; --overwrite replaces it");
  const auto beside = target.has_parent_path() ? target.parent_path() : fs::path(".");
  BOOST_OUTCOME_TRY(place, is_folder(beside));
  if (!place) return error(Errc::io, beside.string() + ": there is no such folder");
  return success();
}

Status refuse_what_is_local(const Settings& settings, const RemoteRegion& region) {
  if (std::find(region.inputs.begin(), region.inputs.end(), "-") != region.inputs.end())
    return error(Errc::usage, "standard input cannot be sent to a daemon; save it in a file below one of its folders");
  if (settings.text("input-list").has_value())
    return error(Errc::usage,
                 "--input-list is not for a job of a daemon: name the daemon's files, folders or patterns");
  if (!settings.text("format").value_or("").empty() || fs::path(region.name).has_extension())
    return error(Errc::usage, "-o '" + region.name +
                                  "': a daemon makes a result with this name, so give no format and no ending; "
                                  "'tessera export' then makes files for other programs");
  return success();
}

}  // namespace

Status region_remotely(Settings& settings, const RemoteRegion& region, const OutputOptions& output) {
  BOOST_OUTCOME_TRYV(refuse_what_is_local(settings, region));
  BOOST_OUTCOME_TRY(
      inputs, remote_inputs(settings, *proto::RegionInputs::descriptor(), only_here({"polygon", "crs", "format"})));
  if (const auto file = settings.text("polygon")) {
    BOOST_OUTCOME_TRY(bytes, read_whole(*file));
    inputs["polygon"] = as_text(bytes);
  }
  inputs["inputs"] = region.inputs;
  inputs["output"] = without_slash(region.name);
  if (!region.crs.empty()) inputs["crs"] = region.crs;
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  proto::StatusInfo job;
  {
    const Interrupt interrupt;
    auto submitted = submit(server, "region", inputs, interrupt.token());
    if (!submitted) return advise_upload(submitted.error(), region.inputs);
    job = std::move(submitted).value();
  }
  if (!detach) return watch_job(server, settings, job.job_id(), output);
  print_detached(settings, job, output);
  return success();
}

Result<std::string> polygons_for_daemon(const std::string& key, const fs::path& file) {
  const std::string ending = file.extension().string();
  if (ending != ".geojson" && ending != ".json")
    return error(Errc::usage, "--" + key + ": a daemon takes polygons as GeoJSON, and " + file.string() +
                                  " does not end in .geojson; 'ogr2ogr polygons.geojson " + file.string() +
                                  "' converts it");
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  return std::string(as_text(bytes));
}

Status draw_remotely(Settings& settings, const std::string& process, const std::string& result, const fs::path& target,
                     const OutputOptions& output, const RemoteTexts& texts) {
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  if (!detach) {
    BOOST_OUTCOME_TRYV(check_target(settings, target));
  }
  std::vector<std::string> as_text_here;
  for (const auto& [key, text] : texts) as_text_here.push_back(key);
  const auto& kind = *proto::Inputs::descriptor()->FindFieldByName(process)->message_type();
  BOOST_OUTCOME_TRY(inputs, remote_inputs(settings, kind, only_here(std::move(as_text_here))));
  for (const auto& [key, text] : texts) inputs[key] = text;
  inputs["triangulation"] = without_slash(result);
  // A file that does not stay gets a unique name, so that it cannot replace a file of another user of the daemon.
  const std::string made =
      detach ? target.filename().string() : client::new_idempotency_key() + target.extension().string();
  inputs["output"] = made;
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  // Errors name the user's target in place of the unique name.
  const auto as_asked = [&](Error failed) {
    if (const auto at = failed.where.find(made); at != std::string::npos)
      failed.where.replace(at, made.size(), target.string());
    return failed;
  };
  const auto submitted = submit(server, process, inputs, interrupt.token());
  if (!submitted) return as_asked(advise_here(submitted.error(), result));
  const auto& job = submitted.value();
  if (detach) {
    print_detached(settings, job, output);
    return success();
  }
  const auto with_advice = [&](Error failed) {
    if (failed.code == Errc::interrupted)
      failed.where += "; " + command_for(settings, "fetch", job.job_id() + " -o " + target.string()) +
                      " fetches what the job makes";
    return as_asked(std::move(failed));
  };
  const auto done = await_job(server, settings, job.job_id(), output, interrupt.token());
  if (!done) return with_advice(done.error());
  const auto fetched = fetch_drawing(server, done.value(), target, output, interrupt.token());
  if (!fetched) return with_advice(fetched.error());
  const auto removed = server.remove_export(done.value().triangulation(), made, interrupt.token());
  if (!removed)
    say_beside("note: the daemon could not remove its copy of the file: %s\n",
               in_plain_words(removed.error().where).c_str());
  return success();
}

bool is_drawing(const proto::StatusInfo& job) {
  constexpr std::array<std::string_view, 6> processes{"dem", "contours", "voronoi", "density", "alpha", "volume"};
  return std::find(processes.begin(), processes.end(), job.process_id()) != processes.end();
}

Status fetch_drawing(client::Server& server, const proto::StatusInfo& job, const fs::path& target,
                     const OutputOptions& output, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(outcome, server.outcome(job.job_id(), stop));
  BOOST_OUTCOME_TRY(files, client::written_files(outcome));
  if (files.size() != 1)
    return error(Errc::io, server.address().text() + ": the server's answer is not what was asked for");
  const auto fetched =
      client::fetch_written(server, job.triangulation(), files, {target}, percent_line("fetching", output), stop);
  clear_line(output);
  BOOST_OUTCOME_TRYV(fetched);
  outcome["output"] = target.string();
  if (!print_drawn(outcome, output))
    return error(Errc::io, server.address().text() + ": the server's answer is not what was asked for");
  return success();
}

}  // namespace tessera::apps
