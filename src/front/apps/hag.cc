// tessera hag: writes LAS and LAZ files back with the height of each point above the ground.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/remote_heights.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/version_option.h"
#include "src/job/arguments.h"
#include "src/result/heights/copies.h"

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

Result<HagRequest> read_request(Settings& settings, const std::vector<std::string>& inputs) {
  HagRequest request{
      .inputs = inputs, .ground = {}, .out = settings.text("output").value_or(""), .command_line = {}, .output = {}};
  if (inputs.empty()) return error(Errc::usage, "no LAS or LAZ file is given; try 'tessera hag --help'");
  if (request.out.empty()) return error(Errc::usage, "no folder for the copies is given; add -o FOLDER");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  request.output = output;
  if (const auto ground = settings.text("ground")) {
    BOOST_OUTCOME_TRY(version, at_version(settings, *ground));
    request.ground = version;
  } else if (settings.text("version")) {
    return error(Errc::usage, "--version is of the result that --ground names, which is not given");
  }
  BOOST_OUTCOME_TRY(number,
                    settings.get("ground-class", [](const std::string& text) { return parse_integer(text, 0, 255); }));
  if (number && request.ground)
    return error(Errc::usage, "--ground-class says of which points the ground is made, but --ground gives the ground");
  request.ground_class = static_cast<int>(number.value_or(2));
  BOOST_OUTCOME_TRY(packing, settings.get("format", parse_las_packing));
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

Status run_hag(Settings& settings, const std::vector<std::string>& inputs,
               const std::vector<std::string>& command_line) {
  BOOST_OUTCOME_TRY(request, read_request(settings, inputs));
  if (request.output.verbose) log_everything();
  if (names_server(settings)) return hag_remotely(settings, request.inputs, request.out, request.output);
  BOOST_OUTCOME_TRYV(refuse_detach(settings));
  request.command_line = command_line;
  std::vector<HeightsFile> files;
  {
    const Interrupt interrupt;
    request.heights.stop = interrupt.token();
    BOOST_OUTCOME_TRY(found, plan_copies(request.inputs, request.out, request.heights, request.overwrite));
    files = std::move(found);
    BOOST_OUTCOME_TRYV(make_directories(request.out));
  }
  BOOST_OUTCOME_TRY(ground, open_ground(request));  // which handles interrupts itself
  const Interrupt interrupt;
  request.heights.stop = interrupt.token();
  const Status written =
      write_copies(ground.surface, files, request.heights, share_line("writing heights", request.output));
  clear_line(request.output);
  BOOST_OUTCOME_TRYV(written);
  print_heights(request.out.string(), files, request.heights.outside.has_value(), request.output);
  return success();
}

}  // namespace

Command add_hag(CLI::App& root) {
  auto command = new_command(
      root, "hag", "Writes LAS and LAZ files back with the height of each point above the ground",
      "  tessera hag 'block/*.laz' -o heights/                       (the ground: points of class 2)\n"
      "  tessera hag 'block/*.laz' -o heights/ --ground-class 11\n"
      "  tessera hag tile.laz -o heights/ --ground ground/           (above a 2D result)\n"
      "  tessera hag 'block/*.las' -o heights/ --format laz --outside 0\n"
      "  tessera hag 'block/*.laz' -o heights/ --ground NAME --server http://127.0.0.1:7070      (by a daemon, "
      "above one of its results)");
  add_value(command, "output", "FOLDER", "the folder for the copies, which have the names of their files", 'o', true);
  add_value(command, "ground-class", "N", "the class of the points that make the ground; default: 2", 0, true);
  add_value(command, "ground", "FOLDER",
            "the ground as a 2D result; default: the ground points of all files; with --server, the name of a result",
            0, true);
  add_value(command, "format", "NAME", "las or laz; default: as each file is", 0, true);
  add_choices(command, "format", "las, laz");
  add_value(command, "outside", "VALUE", "the height of points outside of the hull of the ground points; default: NaN",
            0, true);
  add_version_option(command);
  add_switch(command, "replace", "replace a dimension HeightAboveGround that a file has already", 0, true);
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_threads_option(command);
  add_memory_option(command, "tiles");
  add_remote_options(command);
  add_output_switches(command);
  auto inputs = std::make_shared<std::vector<std::string>>();
  add_argument(command, "inputs", "FILE", *inputs, "LAS and LAZ files, folders or patterns");
  command.run = [settings = command.settings.get(), inputs](const std::vector<std::string>& command_line) {
    return run_hag(*settings, *inputs, command_line);
  };
  return command;
}

}  // namespace tessera::apps
