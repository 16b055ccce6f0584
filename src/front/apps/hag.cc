// tessera hag: writes LAS and LAZ files back with the height of each point above the ground.
#include "src/result/heights/heights.h"

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/say.h"
#include "src/input/cloud/cloud.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

namespace fs = std::filesystem;

struct HagRequest {
  std::vector<std::string> inputs;
  std::optional<fs::path> ground;  // a 2D result; nothing: made of the inputs
  int ground_class = 2;
  fs::path out;
  bool overwrite = false;
  std::uint64_t memory_bytes = 0;
  HeightsOptions heights = {};
  std::vector<std::string> command_line;
  OutputOptions output;
};

// A file and its copy.
struct HagFile {
  fs::path from, to;
  std::uint64_t bytes = 0;
};

Result<LasPacking> parse_packing(const std::string& text) {
  if (text == "las") return LasPacking::las;
  if (text == "laz") return LasPacking::laz;
  return error(Errc::usage, "'" + text + "' is not a format of the copies; the formats are las and laz");
}

Result<HagRequest> read_request(Settings& settings, const std::vector<std::string>& inputs) {
  HagRequest request{
      .inputs = inputs, .ground = {}, .out = settings.text("output").value_or(""), .command_line = {}, .output = {}};
  if (inputs.empty()) return error(Errc::usage, "no LAS or LAZ file is given; try 'tessera hag --help'");
  if (request.out.empty()) return error(Errc::usage, "no folder for the copies is given; add -o FOLDER");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  request.output = output;
  if (const auto ground = settings.text("ground")) request.ground = *ground;
  BOOST_OUTCOME_TRY(number,
                    settings.get("ground-class", [](const std::string& text) { return parse_integer(text, 0, 255); }));
  if (number && request.ground)
    return error(Errc::usage, "--ground-class says of which points the ground is made, but --ground gives the ground");
  request.ground_class = static_cast<int>(number.value_or(2));
  BOOST_OUTCOME_TRY(packing, settings.get("format", parse_packing));
  request.heights.packing = packing.value_or(LasPacking::as_input);
  BOOST_OUTCOME_TRY(outside, settings.get("outside", [](const std::string& text) { return parse_finite(text); }));
  request.heights.outside = outside;
  BOOST_OUTCOME_TRY(replace, settings.on("replace"));
  request.heights.replace = replace;
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  request.overwrite = overwrite;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  request.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  request.heights.threads = threads;
  return request;
}

// Finds the files, and checks all of them before the first is written.
Result<std::vector<HagFile>> find_files(const HagRequest& request, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(cloud, Cloud::open(request.inputs, {.dimension = 3, .threads = request.heights.threads}, stop));
  std::vector<HagFile> files;
  std::map<std::string, fs::path> taken;
  for (const FileInfo& file : cloud.files()) {
    if (file.format != "las" && file.format != "laz")
      return error(Errc::bad_input, file.path.string() + ": is not LAS or LAZ (it is " + file.format +
                                        "); heights are written into copies of LAS and LAZ files");
    fs::path name = file.path.filename();
    if (request.heights.packing == LasPacking::las) name.replace_extension(".las");
    if (request.heights.packing == LasPacking::laz) name.replace_extension(".laz");
    const auto [other, fresh] = taken.try_emplace(name.string(), file.path);
    if (!fresh)
      return error(Errc::usage, file.path.string() + ": has the same name as " + other->second.string() +
                                    "; write them into different folders, one call each");
    const fs::path to = request.out / name;
    BOOST_OUTCOME_TRY(there, is_there(to));
    if (there && !request.overwrite)
      return error(Errc::usage, to.string() + ": exists already; --overwrite replaces it");
    files.push_back({file.path, to, file.bytes});
  }
  return files;
}

// The surface, and the folder in which it was made, if it was.
struct Ground {
  std::optional<TemporaryFolder> made;
  query::StoredTriangulation surface;
};

Result<Ground> open_ground(const HagRequest& request) {
  const query::OpenOptions opening{.memory_bytes = request.memory_bytes};
  if (request.ground) {
    BOOST_OUTCOME_TRY(surface, query::StoredTriangulation::open(*request.ground, opening));
    return Ground{{}, std::move(surface)};
  }
  BOOST_OUTCOME_TRY(folder, TemporaryFolder::make(temporary_name_of_process((request.out / "ground").string())));
  JobOptions job;
  job.cloud.dimension = 2;
  job.cloud.classes = {request.ground_class};
  job.cloud.threads = job.threads = request.heights.threads;
  job.memory_bytes = request.memory_bytes;
  job.command = request.command_line;
  BOOST_OUTCOME_TRYV(make_result_of(std::move(job), request.inputs, folder.path() / "result", request.output));
  BOOST_OUTCOME_TRY(surface, query::StoredTriangulation::open(folder.path() / "result", opening));
  return Ground{std::move(folder), std::move(surface)};
}

void print(const HagRequest& request, const std::vector<HagFile>& files, const std::vector<HeightsCopy>& copies) {
  std::uint64_t points = 0, outside = 0;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < files.size(); ++i) {
    points += copies[i].points;
    outside += copies[i].outside;
    list.push_back({{"input", files[i].from.string()},
                    {"output", files[i].to.string()},
                    {"points", copies[i].points},
                    {"outside", copies[i].outside}});
  }
  if (request.output.json) {
    const nlohmann::ordered_json object{
        {"event", "heights"}, {"files", std::move(list)}, {"points", points}, {"outside", outside}};
    std::printf("%s\n", json_text(object).c_str());
    return;
  }
  if (request.output.quiet) return;
  say("%s: %s points of %s %s have the dimension %s\n", request.out.c_str(), grouped(points).c_str(),
      grouped(files.size()).c_str(), files.size() == 1 ? "file" : "files", height_dimension);
  if (outside > 0)
    say("%s points are outside of the hull of the ground points; their height is %s\n", grouped(outside).c_str(),
        request.heights.outside ? "that of --outside" : "NaN (--outside VALUE writes a number instead)");
}

Status run_hag(Settings& settings, const std::vector<std::string>& inputs,
               const std::vector<std::string>& command_line) {
  BOOST_OUTCOME_TRY(request, read_request(settings, inputs));
  if (request.output.verbose) log_everything();
  request.command_line = command_line;
  std::vector<HagFile> files;
  {
    const Interrupt interrupt;
    BOOST_OUTCOME_TRY(found, find_files(request, interrupt.token()));
    files = std::move(found);
    BOOST_OUTCOME_TRYV(make_directories(request.out));
  }
  BOOST_OUTCOME_TRY(ground, open_ground(request));  // which handles interrupts itself
  const Interrupt interrupt;
  request.heights.stop = interrupt.token();
  std::uint64_t bytes = 0, done = 0;
  for (const HagFile& file : files) bytes += file.bytes;
  const auto progress = share_line("writing heights", request.output);
  std::vector<HeightsCopy> copies;
  for (const HagFile& file : files) {
    auto copy = copy_with_heights(ground.surface, file.from, file.to, request.heights);
    if (!copy) clear_line(request.output);
    BOOST_OUTCOME_TRY(made, std::move(copy));
    copies.push_back(made);
    done += file.bytes;
    if (progress && bytes > 0) progress(static_cast<double>(done) / static_cast<double>(bytes));
  }
  clear_line(request.output);
  print(request, files, copies);
  return success();
}

}  // namespace

Command add_hag(CLI::App& root) {
  auto command =
      new_command(root, "hag", "Writes LAS and LAZ files back with the height of each point above the ground",
                  "  tessera hag 'block/*.laz' -o heights/                       (the ground: points of class 2)\n"
                  "  tessera hag 'block/*.laz' -o heights/ --ground-class 11\n"
                  "  tessera hag tile.laz -o heights/ --ground ground/           (above a 2D result)\n"
                  "  tessera hag 'block/*.las' -o heights/ --format laz --outside 0");
  add_value(command, "output", "FOLDER", "the folder for the copies, which have the names of their files", 'o', true);
  add_value(command, "ground-class", "N", "the class of the points that make the ground; default: 2", 0, true);
  add_value(command, "ground", "FOLDER", "the ground as a 2D result; default: the ground points of all files", 0, true);
  add_value(command, "format", "NAME", "las or laz; default: as each file is", 0, true);
  add_choices(command, "format", "las, laz");
  add_value(command, "outside", "VALUE", "the height of points outside of the hull of the ground points; default: NaN",
            0, true);
  add_switch(command, "replace", "replace a dimension HeightAboveGround that a file has already", 0, true);
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_threads_option(command);
  add_memory_option(command, "tiles");
  add_output_switches(command);
  auto inputs = std::make_shared<std::vector<std::string>>();
  add_argument(command, "inputs", "FILE", *inputs, "LAS and LAZ files, folders or patterns");
  command.run = [settings = command.settings.get(), inputs](const std::vector<std::string>& command_line) {
    return run_hag(*settings, *inputs, command_line);
  };
  return command;
}

}  // namespace tessera::apps
