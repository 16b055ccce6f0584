// tessera track: estimates where the scanner of the points was.
#include "src/surface/track/track.h"
#include "src/base/json/json_text.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/say.h"
#include "src/front/apps/triangulate_options.h"
#include "src/job/open_cloud.h"
#include "src/surface/track/estimate.h"
#include "src/surface/track/pulses.h"
#include "src/surface/track/scan_angles.h"

namespace tessera::apps {
namespace {

void print(const EstimatedTrack& found, const std::string& target, const OutputOptions& output) {
  using Json = nlohmann::ordered_json;
  if (output.json) {
    Json lines = Json::array();
    for (const TrackLine& line : found.lines)
      lines.push_back({{"line", line.line},
                       {"from", line.from == TrackLine::From::pulses ? "pulses" : "scan angles"},
                       {"observations", line.observations},
                       {"windows", line.windows},
                       {"windows_kept", line.kept},
                       {"median_degrees", line.median_degrees},
                       {"degrees_of_99_percent", line.most_degrees},
                       {"height", line.height},
                       {"refused", line.refused}});
    const Json object{{"event", "track"}, {"output", target}, {"lines", std::move(lines)}};
    std::printf("%s\n", json_text(object).c_str());
    return;
  }
  if (output.quiet) return;
  for (const TrackLine& line : found.lines) {
    if (line.refused.empty()) {
      say("line %u: the scanner was %.0f above the points; %zu of %zu half seconds agree\n"
          "line %u: %s are off by %.2f degrees at the median, 99 %% of them by less than %.2f\n",
          line.line, line.height, line.kept, line.windows, line.line,
          line.from == TrackLine::From::pulses ? "pulses" : "scan angles", line.median_degrees, line.most_degrees);
    } else {
      say("line %u: no track: %s (%zu observations)\n", line.line, line.refused.c_str(), line.observations);
    }
  }
  say("%s: %zu of %zu flight lines\n", target.c_str(), found.track.lines().size(), found.lines.size());
}

Status run_track(Settings& settings, const std::vector<std::string>& inputs) {
  const std::string target = settings.text("output").value_or("");
  if (inputs.empty()) return error(Errc::usage, "no point files are given; try 'tessera track --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE.csv");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  BOOST_OUTCOME_TRY(there, is_there(target));
  if (there && !overwrite) return error(Errc::usage, target + ": exists already; --overwrite replaces it");
  JobOptions job;
  BOOST_OUTCOME_TRYV(read_cloud_options(settings, job));
  job.cloud.attributes = {"all"};  // asks for no attribute by name, because missing ones are reported below
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(cloud, open_cloud(inputs, job, interrupt.token()));
  Pulses pulses(cloud.schema());
  ScanAngles angles(cloud.schema());
  const bool with_pulses = pulses.missing().empty(), with_angles = angles.missing().empty();
  if (!with_pulses && !with_angles)
    return error(Errc::usage, "the points have no " + pulses.missing() +
                                  ", which is needed to find pulses with several returns; and no " + angles.missing() +
                                  ", which is needed to use scan angles");
  const std::size_t width = row_bytes(cloud.schema());
  BOOST_OUTCOME_TRYV(cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    if (interrupt.token().stop_requested()) return error(Errc::interrupted, "interrupted while reading points");
    for (std::size_t i = 0; i < batch.points.size(); ++i) {
      const std::byte* row = batch.rows.data() + i * width;
      if (with_pulses) pulses.add(batch.points[i].at, row);
      if (with_angles) angles.add(batch.points[i].at, row);
    }
    return success();
  }));
  const EstimatedTrack found = estimate_track(pulses.take(), angles.take());
  if (found.track.empty()) {
    print(found, target, output);
    return error(Errc::bad_input,
                 found.lines.empty() ? "the points have no pulses with a first and a last return, and no scan angles"
                                     : "neither pulses nor scan angles tell where the scanner was, on any flight line");
  }
  BOOST_OUTCOME_TRYV(write_whole(target, found.track.to_csv()));
  print(found, target, output);
  return success();
}

}  // namespace

Command add_track(CLI::App& root) {
  auto command =
      new_command(root, "track", "Finds where the scanner was, from pulses with several returns, or scan angles",
                  "  tessera track block/*.laz -o track.csv\n"
                  "  tessera surface block/*.laz -o mesh.ply --sensor track:track.csv");
  add_cloud_options(command);
  add_value(command, "output", "PATH", "the CSV file to write, with the columns time,x,y,z,line", 'o', true);
  add_switch(command, "overwrite", "replace a file that exists", 0, true);
  add_output_switches(command);
  auto inputs = std::make_shared<std::vector<std::string>>();
  add_argument(command, "inputs", "FILE|FOLDER", *inputs, "point files, folders of them");
  command.run = [settings = command.settings.get(), inputs](const std::vector<std::string>&) {
    return run_track(*settings, *inputs);
  };
  return command;
}

}  // namespace tessera::apps
