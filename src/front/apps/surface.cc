// tessera surface: writes a closed surface of a 3D result.
#include "src/surface/surface.h"

#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/say.h"
#include "src/job/arguments.h"
#include "src/job/engine_steps.h"
#include "src/job/surface_arguments.h"
#include "src/result/tileset/tileset.h"

namespace tessera::apps {
namespace {

using Bottom = SurfaceOptions::Bottom;

template <class Value, class Parse>
Status read(Settings& settings, const char* key, const Parse& parse, Value& to) {
  BOOST_OUTCOME_TRY(value, settings.get(key, [&](const std::string& text) { return parse(text); }));
  if (value) to = std::move(*value);
  return success();
}

Result<SurfaceOptions> read_options(Settings& settings, const OutputOptions& output) {
  SurfaceOptions options;
  BOOST_OUTCOME_TRYV(read(
      settings, "sensor", [](const std::string& text) { return parse_sensors(text, true); }, options.sensors));
  BOOST_OUTCOME_TRYV(read(settings, "lambda", parse_finite, options.energy.lambda));
  BOOST_OUTCOME_TRYV(read(settings, "alpha", parse_finite, options.energy.alpha));
  BOOST_OUTCOME_TRYV(read(settings, "sigma", parse_sigma, options.energy.sigma));
  BOOST_OUTCOME_TRYV(read(settings, "ray-length", parse_ray_length, options.energy.ray_length));
  BOOST_OUTCOME_TRYV(read(settings, "bottom", parse_bottom, options.bottom));
  BOOST_OUTCOME_TRYV(read(settings, "unknown", parse_unknown, options.unknown_inside));
  BOOST_OUTCOME_TRY(trim, settings.get("trim", [](const std::string& text) { return parse_distance(text); }));
  options.trim = trim;
  BOOST_OUTCOME_TRY(manifold, settings.on("manifold"));
  options.manifold = manifold;
  BOOST_OUTCOME_TRY(smooth, settings.get("smooth", [](const std::string& text) {
    return parse_integer(text, 0, std::numeric_limits<std::uint32_t>::max());
  }));
  options.smooth = static_cast<unsigned>(smooth.value_or(0));
  options.output.format = settings.text("format").value_or("");
  BOOST_OUTCOME_TRY(local, settings.on("local"));
  options.output.local = local;
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  options.output.overwrite = overwrite;
  BOOST_OUTCOME_TRY(resume, settings.on("resume"));
  options.resume = resume;
  BOOST_OUTCOME_TRY(memory, memory_option(settings));
  options.memory_bytes = memory;
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  options.progress = share_line("making the surface", output);
  return options;
}

void print(const Surface& made, const SurfaceOptions& options, const OutputOptions& output) {
  const std::string path = made.mesh.path.string();
  if (output.json) {
    std::printf("%s\n", to_json(made, path).c_str());
    return;
  }
  if (output.quiet) return;
  say("%s: %llu triangles, %llu vertices%s\n", path.c_str(), static_cast<unsigned long long>(made.mesh.cells),
      static_cast<unsigned long long>(made.mesh.vertices),
      options.trim                     ? "; it has holes where longer edges were left out"
      : options.bottom == Bottom::open ? "; closed except at the lower side of the hull"
                                       : "; closed");
  say("%s; median scale %.4g\n", made.sensors.c_str(), made.sigma);
  if (made.split > 0)
    say("%llu vertices were added where the surface touches itself\n", static_cast<unsigned long long>(made.split));
  if (made.no_rays > 0)
    say("%llu points have no direction to a sensor, and so no ray\n", static_cast<unsigned long long>(made.no_rays));
  if (made.guessed > 0)
    say("%llu points have no place on the track; their sensors are taken to be straight above\n",
        static_cast<unsigned long long>(made.guessed));
  say("digest %s\n", digest_text(made.digest).c_str());
  if (!made.mesh.note.empty()) say("%s\n", made.mesh.note.c_str());
}

Status run_surface(Settings& settings, const OneStep& made_of) {
  const std::string target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera surface --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE.ply");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();
  BOOST_OUTCOME_TRY(options, read_options(settings, output));
  BOOST_OUTCOME_TRYV(check_surface_options(options));
  BOOST_OUTCOME_TRYV(find_surface_target(target, options.output));
  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    const Interrupt interrupt;
    Engine engine(options.threads, options.memory_bytes, kinds_of_stages());
    Progress progress;
    progress.log = log_debug;
    EngineSteps steps(engine,
                      {.threads = options.threads, .memory_bytes = options.memory_bytes, .resumable = options.resume},
                      progress);
    auto result = make_surface(folder, target, options, steps, interrupt.token());
    clear_line(output);
    BOOST_OUTCOME_TRY(made, std::move(result));
    print(made, options, output);
    return success();
  });
}

}  // namespace

Command add_surface(CLI::App& root) {
  auto command =
      new_command(root, "surface", "Makes a closed surface of points or of a 3D result",
                  "  tessera surface block/*.laz -o mesh.ply                     (from points, in one step)\n"
                  "  tessera surface out/ -o mesh.ply --lambda 2                 (of a 3D result; smoother)\n"
                  "  tessera surface out/ -o tiles/ --format vtu                 (a folder with one .vtu a tile, and a "
                  ".pvtu over them)\n"
                  "  tessera surface scan.ply -o mesh.obj --bottom free --sensor 'point:0,0,1.7;12,3,1.7'");
  add_value(command, "sensor", "WHICH",
            "where the sensor was that saw the points: auto (default), vertical (straight above), fields (x_origin, "
            "y_origin, z_origin or nx, ny, nz of the points), scan-angle (by gps_time), track:FILE.csv (by gps_time; "
            "'tessera track' makes such a file), or point:X,Y,Z;X,Y,Z;... (the nearest of these places)");
  add_value(command, "lambda", "NUMBER",
            "how much the quality of facets counts; a larger number makes a smoother surface; default: 1");
  add_value(command, "alpha", "NUMBER", "how much a ray, the line from a point to its sensor, counts; default: 32");
  add_value(command, "sigma", "LENGTH",
            "how far a point may be from the surface, in units of the coordinates; default: auto, for each point from "
            "the length of its edges");
  add_value(command, "ray-length", "NUMBER",
            "how far a ray goes towards its sensor, as a multiple of sigma; full: all the way; default: 100");
  add_value(command, "bottom", "WHICH",
            "what is below all points: closed (default): inside, and the surface has a bottom; open: inside, but the "
            "surface has no bottom; free: outside");
  add_choices(command, "bottom", "closed, open, free");
  add_value(command, "unknown", "WHICH", "what a place is that no ray has seen: solid (default) or empty");
  add_choices(command, "unknown", "solid, empty");
  add_value(
      command, "trim", "LENGTH",
      "leave out triangles with a longer edge, which bridge places that were not seen; the surface is then not closed");
  add_switch(
      command, "manifold",
      "split vertices and edges where the surface touches itself, for programs that need a manifold; no vertex moves");
  add_value(command, "smooth", "N", "how many rounds of smoothing (Taubin's), which move the vertices; default: 0");
  add_value(command, "format", "NAME",
            "a format of 'tessera export', or 3dtiles: a folder with levels of detail for viewers, of a manifold "
            "surface; default: the format of the ending of --output");
  add_choices(command, "format", export_format_names() + ", " + tileset_format);
  add_value(command, "output", "PATH",
            "the file to write; a folder, or a name without an ending, gets one file for each tile", 'o', true);
  add_switch(command, "local",
             "ply, obj, off, stl: write coordinates relative to the lower corner of the result's box, rounded down to "
             "whole numbers");
  add_memory_option(command, "tiles");
  add_threads_option(command);
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_switch(command, "resume",
             "continue an interrupted run of the same command, which has left its state in PATH.surface, and leave the "
             "state there when interrupted again; for point files, keep their result with --keep-result, and name that "
             "result in the second command",
             0, true);
  add_output_switches(command);
  auto sources = add_sources(command, 3);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_surface(*settings, {.sources = *sources,
                                   .dimension = 3,
                                   .beside = settings->text("output").value_or(""),
                                   .command_line = command_line,
                                   .carry_all = true});
  };
  return command;
}

}  // namespace tessera::apps
