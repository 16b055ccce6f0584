// tessera update: removes points of a result and adds others.
#include "src/delaunay/update/update.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/delaunay/update/select_points.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/remote_update.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/update_command.h"
#include "src/front/apps/version_option.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/cloud/cloud.h"
#include "src/input/npy/npy_header.h"
#include "src/job/arguments.h"
#include "src/job/engine_steps.h"
#include "src/job/new_points.h"
#include "src/job/told_update.h"
#include "src/job/version.h"
#include "src/result/far_files.h"
#include "src/result/tile_source.h"
#include "src/result/voronoi/clip_region.h"
#include "src/result/voronoi/read_clip.h"

namespace tessera::apps {
namespace {

namespace fs = std::filesystem;

// Options that may be given several times.
struct UpdateFiles {
  std::string result;
  std::vector<std::string> add, polygons, inputs;
};

struct AskedUpdate {
  fs::path result;
  UpdateFiles files = {};
  bool replace = false;
  std::optional<fs::path> ids = {};  // of points to remove
  std::optional<std::string> box = {};
  PointSelection selection = {};
  UpdateOptions options = {};
  int dimension = 3;  // of the result
  std::uint64_t memory_bytes = 0;
  OutputOptions output = {};
};

// Of a change of the result itself.
Status read_version_options(Settings& settings, UpdateOptions& options, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(
      keep, settings.get("keep-versions", [](const std::string& text) { return parse_integer(text, 1, 1'000'000); }));
  BOOST_OUTCOME_TRY(wait, settings.on("wait"));
  const bool in_place = options.to.empty() && !options.dry_run;
  if (keep && !in_place) return error(Errc::usage, "--keep-versions is for a change of the result itself, without -o");
  if (wait && !in_place) return error(Errc::usage, "--wait is for a change of the result itself, without -o");
  if (keep) options.version.keep = static_cast<std::uint32_t>(*keep);
  if (wait) options.version.lock.locked = wait_for_lock(stop);
  return success();
}

fs::path written_to(const AskedUpdate& request) {
  return request.options.to.empty() ? request.result : request.options.to;
}

// How many points a tile may have.
Result<std::uint64_t> parse_tile_limit(const std::string& text) {
  BOOST_OUTCOME_TRY(count, parse_count(text));
  if (count == 0) return error(Errc::usage, "must be at least 1");
  return count;
}

Result<AskedUpdate> read_request(Settings& settings, const UpdateFiles& files) {
  if (files.result.empty()) return error(Errc::usage, "no result folder is given; try 'tessera update --help'");
  AskedUpdate request{.result = files.result, .files = files, .box = settings.text("remove-box")};
  BOOST_OUTCOME_TRY(output, output_options(settings));
  request.output = output;
  if (const auto ids = settings.text("remove-ids")) request.ids = *ids;
  BOOST_OUTCOME_TRY(classes, settings.get("remove-class", [](const std::string& text) { return parse_classes(text); }));
  request.selection.classes = classes.value_or(std::vector<int>{});
  BOOST_OUTCOME_TRY(times, settings.get("remove-time", parse_times));
  if (times) request.selection.times = PointSelection::Times{times->first, times->second};
  BOOST_OUTCOME_TRY(replace, settings.on("replace"));
  request.replace = replace;
  BOOST_OUTCOME_TRY(dry_run, settings.on("dry-run"));
  request.options.dry_run = dry_run;
  request.options.to = settings.text("output").value_or("");
  const bool removes = request.ids || request.box || times || !request.selection.classes.empty() ||
                       !files.polygons.empty() || !files.inputs.empty();
  if (files.add.empty() && !removes)
    return error(Errc::usage,
                 "nothing is to be changed; add --add FILES, --remove-ids FILE, --remove-class LIST, --remove-box BOX, "
                 "--remove-polygon FILE, --remove-time A..B or --remove-input FILE");
  if (replace && files.add.empty()) return error(Errc::usage, "--replace needs new points; add --add FILES");
  BOOST_OUTCOME_TRY(limit, settings.get("max-points-per-tile", parse_tile_limit));
  request.options.tile_points = limit.value_or(0);
  BOOST_OUTCOME_TRY(resume, settings.on("resume"));
  request.options.resume = resume && !dry_run;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  request.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  request.options.threads = threads;
  request.options.progress = share_line("changing the result", output);
  return request;
}

// All points of the files, with the attributes of the result.
Status add_new_points(AskedUpdate& asked, const Manifest& manifest, ResultChange& change, const std::stop_token& stop) {
  const std::vector<std::string>& files = asked.files.add;
  BOOST_OUTCOME_TRY(cloud, Cloud::open(files, options_of_new_points(manifest, asked.options.threads), stop));
  const std::string name = files.front() + (files.size() > 1 ? " and others" : "");
  BOOST_OUTCOME_TRY(read, read_new_points(cloud, name, manifest, asked.result, stop));
  change.add = std::move(read.points);
  change.rows = std::move(read.rows);
  asked.options.inputs = std::move(read.inputs);
  return success();
}

// The points that the options name, except those of a list of source indices.
Status read_selection(AskedUpdate& request, const Manifest& manifest) {
  PointSelection& selection = request.selection;
  if (request.box) {
    auto box = parse_crop(*request.box, 3);
    if (!box) return error(box.error().code, "--remove-box: " + box.error().where);
    selection.box = box.value();
    const bool heights = std::isfinite(selection.box->lo.z);
    const auto& schema = manifest.schema;
    const bool known = std::any_of(schema.begin(), schema.end(), [](const auto& a) { return a.name == "z"; });
    if (heights && manifest.dimension == 2 && !known)
      return error(Errc::usage, "--remove-box: " + *request.box + " has heights, and the points of " +
                                    request.result.string() + " have none; give xmin,ymin,xmax,ymax");
  }
  for (const std::string& file : request.files.polygons) {
    auto region = voronoi::file_region(file, manifest);
    if (!region) return error(region.error().code, "--remove-polygon: " + region.error().where);
    selection.regions.push_back(std::make_shared<const voronoi::ClipRegion>(std::move(region).value()));
  }
  for (const std::string& file : request.files.inputs) {
    auto ids = ids_of_input(request.result, manifest, file);
    if (!ids) return error(ids.error().code, "--remove-input: " + ids.error().where);
    selection.inputs.push_back(ids.value());
  }
  return success();
}

Result<ResultChange> read_change(AskedUpdate& request, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(opened, TileSource::open(request.result));
  BOOST_OUTCOME_TRYV(check_changeable(request.result, opened.manifest()));
  const TileSource source = opened.without_columns().stopped_by(stop);
  const Manifest& manifest = source.manifest();
  request.dimension = manifest.dimension;
  ResultChange change;
  if (request.ids) {
    BOOST_OUTCOME_TRY(file, open_file(*request.ids));
    BOOST_OUTCOME_TRY(ids, read_npy_integers(*file));
    for (const std::uint64_t id : ids) change.remove.push_back(PointId{id});
  }
  BOOST_OUTCOME_TRYV(read_selection(request, manifest));
  if (!request.files.add.empty()) {
    BOOST_OUTCOME_TRYV(add_new_points(request, manifest, change, stop));
  }
  if (request.replace) request.selection.places = change.add;
  BOOST_OUTCOME_TRY(selected, select_points(source, request.selection, request.options.threads, stop));
  change.remove.insert(change.remove.end(), selected.begin(), selected.end());
  if (!selected.empty()) change.chosen_from = manifest.version;
  return change;
}

// The words of a command that say what is changed. A command that continues another may print differently and work
// with more memory.
std::vector<std::string> words_of_change(const std::vector<std::string>& command) {
  constexpr std::array<std::string_view, 5> switches{"--resume", "--quiet", "--verbose", "-v", "--json"};
  constexpr std::array<std::string_view, 2> values{"--memory", "--threads"};
  std::vector<std::string> words;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const std::string& word = command[i];
    if (std::ranges::find(switches, word) != switches.end()) continue;
    const std::string_view name = std::string_view(word).substr(0, word.find('='));
    if (std::ranges::find(values, name) == values.end()) {
      words.push_back(word);
    } else if (name == word) {
      ++i;  // the value is the next word
    }
  }
  return words;
}

// Whether an earlier run of the same command has made the result already. If so, this is told.
Result<bool> was_made(const AskedUpdate& request) {
  const auto is_same = [&](const std::vector<std::string>& command) {
    return words_of_change(command) == words_of_change(request.options.command);
  };
  BOOST_OUTCOME_TRY(made, finish_earlier(request.result, request.options, is_same));
  if (!made) return false;
  auto told = told_of_made(*made, written_to(request).string());
  told["made_earlier"] = true;
  print_updated(told, request.output);
  return true;
}

Status run_update(Settings& settings, const UpdateFiles& files, const std::vector<std::string>& command_line) {
  BOOST_OUTCOME_TRY(request, read_request(settings, files));
  if (request.output.verbose) log_everything();
  if (names_server(settings))
    return update_remotely(settings, {files.result, files.add, files.polygons, files.inputs}, request.output);
  BOOST_OUTCOME_TRYV(refuse_detach(settings));
  BOOST_OUTCOME_TRYV(result::refuse_far(request.result));
  request.options.command = command_line;
  request.options.software_version = version();
  const Interrupt interrupt;
  BOOST_OUTCOME_TRYV(read_version_options(settings, request.options, interrupt.token()));
  BOOST_OUTCOME_TRY(made, was_made(request));
  if (made) return success();
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
  print_updated(told_of(updated, {.output = written_to(request).string(),
                                  .dry_run = request.options.dry_run,
                                  .added = change.add.size(),
                                  .dimension = request.dimension,
                                  .memory_bytes = request.memory_bytes,
                                  .threads = request.options.threads}),
                request.output);
  return success();
}

}  // namespace

Command add_update(CLI::App& root) {
  auto command =
      new_command(root, "update", "Removes points of a result and adds others, at the cost of what changes",
                  "  tessera update out/ --add 'new/*.laz'\n"
                  "  tessera update out/ --add 'new/*.laz' -o next/           (out/ stays as it is)\n"
                  "  tessera update out/ --remove-ids ids.npy                 (source indices)\n"
                  "  tessera update out/ --remove-class 7,18 --keep-versions 5\n"
                  "  tessera update out/ --remove-box 0,0,50,50 --add plot.laz\n"
                  "  tessera update out/ --remove-input old.laz --add new.laz -o next/\n"
                  "  tessera update out/ --remove-polygon site.geojson --remove-time 1000..2000 -o next/\n"
                  "  tessera update out/ --add corrected.laz --replace -o next/\n"
                  "  tessera update out/ --remove-class 7 --dry-run           (tells what would change)\n"
                  "  tessera update NAME --add 'new/*.laz' --server http://127.0.0.1:7070     (by a daemon)");
  auto files = std::make_shared<UpdateFiles>();
  add_value(command, "output", "FOLDER",
            "make a new result in this folder, and leave the given one as it is; default: a new version of it", 'o',
            true);
  add_value(command, "keep-versions", "N",
            "how many of the newest versions stay readable, also after later changes; default: as before, at first 1",
            0, true);
  add_switch(command, "wait", "wait while another program changes the result, instead of refusing", 0, true);
  add_values(command, "add", "FILES", files->add,
             "add all points of these files: a file, a folder or a pattern; may be given several times");
  add_switch(command, "replace", "new points take the places of all points with the same coordinates", 0, true);
  add_value(
      command, "remove-ids", "FILE",
      "remove the points with these source indices: a NumPy list of integers; with --server also upload:NAME/FILE", 0,
      true);
  add_value(command, "remove-class", "LIST", "remove the points of these LAS classes, for example 7,18", 0, true);
  add_value(command, "remove-box", "BOX",
            "xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax: remove the points inside", 0, true);
  add_values(command, "remove-polygon", "FILE", files->polygons,
             "remove the points in the polygons of a GeoJSON, GeoPackage, FlatGeobuf or Shapefile file, at any height");
  add_value(command, "remove-time", "A..B", "remove the points whose attribute gps_time is from A to B", 0, true);
  add_values(command, "remove-input", "FILE", files->inputs,
             "remove the points that came from this input file, which need not exist any more");
  add_value(command, "max-points-per-tile", "N",
            "split tiles that this or a later change leaves with more points, for example 500k; default: as before, at "
            "first twice the points of the largest tile, and at least 100k",
            0, true);
  add_switch(command, "dry-run", "write nothing, and tell what would change", 0, true);
  add_switch(
      command, "resume",
      "continue an interrupted run of the same command, which has left its state in FOLDER.update, and leave the "
      "state there when interrupted again",
      0, true);
  add_memory_option(command, "tiles");
  add_threads_option(command);
  add_remote_options(command);
  add_output_switches(command);
  add_argument(command, "result", "FOLDER", files->result, "result folder; with --server, the name of a result");
  command.run = [settings = command.settings.get(), files](const std::vector<std::string>& command_line) {
    return run_update(*settings, *files, command_line);
  };
  return command;
}

}  // namespace tessera::apps
