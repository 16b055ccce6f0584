#include "src/apps/remote_drawing.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "src/apps/interrupt.h"
#include "src/apps/percent_line.h"
#include "src/apps/remote_inputs.h"
#include "src/apps/server_options.h"
#include "src/apps/watching.h"
#include "src/base/option.h"
#include "src/client/written.h"
#include "src/files/whole_file.h"
#include "src/job/region_job.h"
#include "src/report/human.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

std::string without_slash(std::string name) {
  while (name.size() > 1 && name.ends_with('/')) name.pop_back();
  return name;
}

Result<proto::StatusInfo> submit(Server& server, const std::string& process, const Json& inputs,
                                 const std::stop_token& stop) {
  auto submitted = server.submit(process, inputs, new_idempotency_key(), stop);
  if (!submitted && submitted.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; 'tessera jobs' tells whether the daemon has the job");
  return submitted;
}

const google::protobuf::Descriptor& inputs_of(const std::string& process) {
  return process == "dem" ? *proto::DemInputs::descriptor() : *proto::ContoursInputs::descriptor();
}

Status check_target(const Settings& settings, const fs::path& target) {
  std::error_code none;
  if (fs::is_directory(target, none)) return error(Errc::usage, target.string() + ": is a folder");
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  if (!overwrite && fs::exists(target, none))
    return error(Errc::usage, target.string() + ": exists already; --overwrite replaces it");
  const auto beside = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(beside, none)) return error(Errc::io, beside.string() + ": there is no such folder");
  return success();
}

}  // namespace

Status region_remotely(Settings& settings, const std::vector<std::string>& inputs, const std::string& out,
                       const OutputOptions& output) {
  if (settings.text("input-list").has_value())
    return error(Errc::usage, "--input-list is not for a job of a daemon: name its files, folders or patterns");
  if (settings.text("format").has_value() || !fs::path(out).extension().empty())
    return error(Errc::usage, "-o '" + out +
                                  "': a daemon makes a result of this name; 'tessera export' brings it as a "
                                  "file of another program");
  BOOST_OUTCOME_TRY(asked, remote_inputs(settings, *proto::RegionInputs::descriptor(), only_here({"polygon"})));
  if (const auto file = settings.text("polygon")) {
    BOOST_OUTCOME_TRY(bytes, read_whole(*file));
    asked["polygon"] = as_text(bytes);
  }
  asked["inputs"] = inputs;
  asked["output"] = without_slash(out);
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  proto::StatusInfo job;
  {
    const Interrupt interrupt;
    auto submitted = submit(server, "region", asked, interrupt.token());
    if (!submitted) return advise_upload(submitted.error(), inputs);
    job = std::move(submitted).value();
  }
  if (!detach) return watch_job(server, settings, job.job_id(), output);
  print_detached(settings, job, output);
  return success();
}

Status draw_remotely(Settings& settings, const std::string& process, const std::string& result, const fs::path& target,
                     const OutputOptions& output) {
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  if (!detach) {
    BOOST_OUTCOME_TRYV(check_target(settings, target));
  }
  BOOST_OUTCOME_TRY(inputs, remote_inputs(settings, inputs_of(process), only_here({})));
  inputs["triangulation"] = without_slash(result);
  // A name of its own: what others have drawn of the result stays.
  const std::string made = new_idempotency_key() + target.extension().string();
  inputs["output"] = detach ? target.filename().string() : made;
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  auto submitted = submit(server, process, inputs, interrupt.token());
  if (!submitted) return in_flags(submitted.error());
  const std::string id = submitted.value().job_id();
  if (detach) {
    print_detached(settings, submitted.value(), output);
    return success();
  }
  BOOST_OUTCOME_TRY(done, await_job(server, settings, id, output, interrupt.token()));
  BOOST_OUTCOME_TRY(outcome, server.outcome(id, interrupt.token()));
  BOOST_OUTCOME_TRY(files, written_files(outcome));
  const auto fetched = fetch_written(
      server, done.triangulation(), files, [&](const WrittenFile&) { return target; }, percent_line("fetching", output),
      interrupt.token());
  clear_line(output);
  BOOST_OUTCOME_TRYV(fetched);
  if (const auto removed = server.remove_export(done.triangulation(), made, interrupt.token()); !removed)
    std::fprintf(stderr, "note: the file stays at the daemon, too: %s\n",
                 in_plain_words(removed.error().where).c_str());
  outcome["output"] = target.string();
  outcome.erase("written");
  if (output.json) {
    print_json_line(outcome);
  } else if (const auto text = drawn_text(outcome); text && !output.quiet) {
    std::fputs(text->c_str(), stdout);
  }
  return success();
}

std::optional<std::string> drawn_text(const Json& outcome) {
  try {
    const auto number = [&](const char* key) { return outcome.at(key).get<std::uint64_t>(); };
    const std::string event = outcome.at("event"), name = outcome.at("output");
    if (event == "dem")
      return name + ": " + grouped(number("width")) + " x " + grouped(number("height")) + " pixels, " +
             grouped(number("width") * number("height") - number("pixels")) + " of them without a value, " +
             human_bytes(number("bytes")) + "\n";
    if (event == "contours")
      return name + ": " + grouped(number("lines")) + " lines, " + grouped(number("closed")) + " of them closed, at " +
             grouped(number("levels")) + " levels, " + grouped(number("vertices")) + " vertices, " +
             human_bytes(number("bytes")) + "\n";
    if (event != "finished" || !outcome.contains("units_read")) return std::nullopt;
    RegionSummary region{.out = name,
                         .dimension = outcome.at("dimension"),
                         .vertices = number("vertices"),
                         .cells = number("cells"),
                         .final = outcome.value("final", number("cells")),
                         .complete = outcome.value("complete", true)};
    region.figures = {.units = number("units"),
                      .points = outcome.value("points", std::uint64_t{0}),
                      .bytes = number("input_bytes"),
                      .units_read = number("units_read"),
                      .points_read = number("points_read"),
                      .bytes_read = number("read_bytes"),
                      .rounds = number("rounds"),
                      .seconds = outcome.value("seconds", 0.0)};
    return region_text(region);
  } catch (const Json::exception&) {  // of another daemon, with other fields
    return std::nullopt;
  }
}

}  // namespace tessera
