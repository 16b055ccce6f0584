// tessera update: removes points of a result and adds others.
#include "src/delaunay/update/update.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/delaunay/update/select_points.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/say.h"
#include "src/front/apps/update_command.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/cloud/cloud.h"
#include "src/input/npy/npy_header.h"
#include "src/job/arguments.h"
#include "src/job/engine_steps.h"
#include "src/job/estimate.h"
#include "src/job/report/human.h"
#include "src/job/version.h"
#include "src/result/store/digest.h"
#include "src/result/tile_source.h"

namespace tessera::apps {
namespace {

namespace fs = std::filesystem;

struct UpdateRequest {
  fs::path result;
  std::optional<std::string> add;  // files
  std::optional<fs::path> ids;     // of points to remove
  std::optional<std::string> box;
  PointSelection selection = {};
  UpdateOptions options = {};
  int dimension = 3;  // of the result
  std::uint64_t memory_bytes = 0;
  OutputOptions output = {};
};

Result<UpdateRequest> read_request(Settings& settings, const std::string& result) {
  if (result.empty()) return error(Errc::usage, "no result folder is given; try 'tessera update --help'");
  UpdateRequest request{.result = result, .add = settings.text("add"), .ids = {}, .box = settings.text("remove-box")};
  BOOST_OUTCOME_TRY(output, output_options(settings));
  request.output = output;
  if (const auto ids = settings.text("remove-ids")) request.ids = *ids;
  BOOST_OUTCOME_TRY(classes, settings.get("remove-class", [](const std::string& text) { return parse_classes(text); }));
  request.selection.classes = classes.value_or(std::vector<int>{});
  BOOST_OUTCOME_TRY(dry_run, settings.on("dry-run"));
  request.options.dry_run = dry_run;
  request.options.to = settings.text("output").value_or("");
  if (!dry_run && request.options.to.empty())
    return error(Errc::usage, "no folder for the new result is given; add -o FOLDER, or --dry-run to write nothing");
  if (!request.add && !request.ids && !request.box && request.selection.classes.empty())
    return error(
        Errc::usage,
        "nothing is to be changed; add --add FILES, --remove-ids FILE, --remove-class LIST or --remove-box BOX");
  BOOST_OUTCOME_TRY(resume, settings.on("resume"));
  request.options.resume = resume && !dry_run;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  request.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  request.options.threads = threads;
  request.options.progress = share_line("changing the result", output);
  return request;
}

std::string text_of(const std::vector<Attribute>& schema) {
  std::string text;
  for (const Attribute& attribute : schema) text += (text.empty() ? "" : ", ") + attribute.name;
  return text.empty() ? "none" : text;
}

// All points of the files, with the attributes of the result.
Status read_new_points(UpdateRequest& request, const Manifest& manifest, ResultChange& change,
                       const std::stop_token& stop) {
  CloudOptions options{.dimension = manifest.dimension, .heights = false, .threads = request.options.threads};
  for (const Attribute& attribute : manifest.schema) {
    if (manifest.dimension == 2 && attribute.name == "z") {
      options.heights = true;
    } else {
      options.attributes.push_back(attribute.name);
    }
  }
  BOOST_OUTCOME_TRY(cloud, Cloud::open({*request.add}, options, stop));
  if (cloud.schema() != manifest.schema)
    return error(Errc::usage, *request.add + ": the new points have other attributes (" + text_of(cloud.schema()) +
                                  ") than " + request.result.string() + " (" + text_of(manifest.schema) +
                                  "), or attributes of other types");
  if (!cloud.crs().empty() && !manifest.crs.empty() && cloud.crs() != manifest.crs)
    return error(Errc::usage,
                 *request.add + ": the new points have another coordinate system than " + request.result.string());
  for (const FileInfo& file : cloud.files()) {
    request.options.inputs.push_back({file.path.string(), file.bytes, file.modified_ns});
  }
  const auto counts = cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while new points were read");
    for (const LocalPoint& p : batch.points) change.add.push_back(p.at);
    change.rows.insert(change.rows.end(), batch.rows.begin(), batch.rows.end());
    return success();
  });
  if (!counts) return counts.error();
  return success();
}

Result<ResultChange> read_change(UpdateRequest& request, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(opened, TileSource::open(request.result));
  const TileSource source = opened.stopped_by(stop);
  const Manifest& manifest = source.manifest();
  BOOST_OUTCOME_TRYV(check_changeable(request.result, manifest));
  request.dimension = manifest.dimension;
  ResultChange change;
  if (request.ids) {
    BOOST_OUTCOME_TRY(file, open_file(*request.ids));
    BOOST_OUTCOME_TRY(ids, read_npy_integers(*file));
    for (const std::uint64_t id : ids) change.remove.push_back(PointId{id});
  }
  if (request.box) {
    auto box = parse_crop(*request.box, manifest.dimension);
    if (!box) return error(box.error().code, "--remove-box: " + box.error().where);
    request.selection.box = box.value();
  }
  BOOST_OUTCOME_TRY(selected, select_points(source, request.selection, request.options.threads, stop));
  change.remove.insert(change.remove.end(), selected.begin(), selected.end());
  if (request.add) {
    BOOST_OUTCOME_TRYV(read_new_points(request, manifest, change, stop));
  }
  return change;
}

// As the estimate of a triangulation, for the points of the tiles that are triangulated.
double seconds_of(const UpdateRequest& request, const Updated& updated) {
  const std::uint64_t limit = updated.old_points / std::max<std::uint64_t>(updated.awake, 1) + 1;
  return estimate(request.dimension, KernelKind::flat, TileKind::cells, updated.old_points, limit, true, 0,
                  {request.memory_bytes, request.options.threads})
      .seconds;
}

void print(const UpdateRequest& request, const ResultChange& change, const Updated& updated) {
  const bool dry = request.options.dry_run;
  const double seconds = seconds_of(request, updated);
  if (request.output.json) {
    nlohmann::ordered_json told{{"event", dry ? "would_update" : "updated"}};
    if (!dry) told["output"] = request.options.to.string();
    told["removed"] = updated.removed;
    told["added"] = change.add.size();
    told["first_new_id"] = updated.first_new;
    told["duplicates"] = updated.duplicates;
    told["way"] = updated.anew ? "anew" : "exchange";
    told["tiles_begun"] = updated.begun;
    told["tiles_awake"] = updated.awake;
    told["tiles_changed"] = updated.written;
    told["points_sent"] = updated.exchange.sent;
    if (dry) {
      told["bytes"] = updated.old_bytes;
      told["seconds"] = seconds;
    }
    if (!dry) {
      told["tiles"] = updated.tiles;
      told["vertices"] = updated.vertices;
      told["cells"] = updated.cells;
      if (updated.digest) told["digest"] = digest_text(*updated.digest);
    }
    std::printf("%s\n", json_text(told).c_str());
    return;
  }
  if (request.output.quiet) return;
  say("%s points %s removed, %s added (%s of them equal to other points)\n", grouped(updated.removed).c_str(),
      dry ? "would be" : "were", grouped(change.add.size()).c_str(), grouped(updated.duplicates).c_str());
  if (updated.anew) {
    say("most tiles have new or removed points, so all tiles %s triangulated anew, which costs less\n",
        dry ? "would be" : "were");
  } else {
    say("%s tiles %s triangulated again, and %s of them %s\n", grouped(updated.awake).c_str(),
        dry ? "would be" : "were", grouped(updated.written).c_str(), dry ? "would change" : "have changed");
  }
  if (dry) {
    say("about %s would be written, in about %s\n", human_bytes(updated.old_bytes).c_str(),
        human_seconds(seconds).c_str());
    return;
  }
  say("%s: %s vertices, %s cells in %s tiles\n", request.options.to.c_str(), grouped(updated.vertices).c_str(),
      grouped(updated.cells).c_str(), grouped(updated.tiles).c_str());
}

Status run_update(Settings& settings, const std::string& result, const std::vector<std::string>& command_line) {
  BOOST_OUTCOME_TRY(request, read_request(settings, result));
  if (request.output.verbose) log_everything();
  request.options.command = command_line;
  request.options.software_version = version();
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(change, read_change(request, interrupt.token()));
  Engine engine(request.options.threads, request.memory_bytes, kinds_of_stages());
  Progress progress;
  progress.log = log_debug;
  EngineStages stages(
      engine,
      {.threads = request.options.threads, .memory_bytes = request.memory_bytes, .resumable = request.options.resume},
      progress);
  auto result_of_change = update_result(request.result, change, request.options, stages, interrupt.token());
  clear_line(request.output);
  BOOST_OUTCOME_TRY(updated, std::move(result_of_change));
  print(request, change, updated);
  return success();
}

}  // namespace

Command add_update(CLI::App& root) {
  auto command = new_command(root, "update", "Removes points of a result and adds others, at the cost of what changes",
                             "  tessera update out/ --add 'new/*.laz' -o next/\n"
                             "  tessera update out/ --remove-ids ids.npy -o next/        (source indices)\n"
                             "  tessera update out/ --remove-class 7,18 -o next/         (LAS noise)\n"
                             "  tessera update out/ --remove-box 0,0,50,50 --add plot.laz -o next/\n"
                             "  tessera update out/ --remove-class 7 --dry-run           (tells what would change)");
  add_value(command, "output", "FOLDER", "the folder of the new result; the given one stays as it is", 'o', true);
  add_value(command, "add", "FILES", "add all points of these files: a file, a folder or a pattern", 0, true);
  add_value(command, "remove-ids", "FILE", "remove the points with these source indices: a NumPy list of integers", 0,
            true);
  add_value(command, "remove-class", "LIST",
            "remove the points of these LAS classes, for example 7,18, and all duplicates of them", 0, true);
  add_value(command, "remove-box", "BOX",
            "xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax: remove the points inside", 0, true);
  add_switch(command, "dry-run", "write nothing, and tell what would change", 0, true);
  add_switch(
      command, "resume",
      "continue an interrupted run of the same command, which has left its state in FOLDER.update, and leave the "
      "state there when interrupted again",
      0, true);
  add_memory_option(command, "tiles");
  add_threads_option(command);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  add_argument(command, "result", "FOLDER", *folder, "result folder");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>& command_line) {
    return run_update(*settings, *folder, command_line);
  };
  return command;
}

}  // namespace tessera::apps
