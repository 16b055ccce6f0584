// tessera export: writes a result as a file for other programs.
#include "src/result/export/export.h"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/one_step.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/remote_result.h"
#include "src/front/apps/server_options.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

// Returns a function that draws the progress on one line of the terminal, when the percentage changes. Returns null if
// nothing is to be drawn.
std::function<void(double)> progress_line(const OutputOptions& output) {
  if (output.quiet || output.json || output.verbose || isatty(STDERR_FILENO) == 0) return {};
  return [shown = -1](double fraction) mutable {
    const int percent = static_cast<int>(fraction * 100);
    if (percent == shown) return;
    shown = percent;
    // At 100 % a spatial index may still have to be made, and the file written back to disk.
    const std::string text = percent < 100 ? "exporting " + std::to_string(percent) + " %" : "finishing     ";
    std::fprintf(stderr, "\r%s", text.c_str());
  };
}

Status run_export(Settings& settings, const OneStep& made_of) {
  const std::filesystem::path target = settings.text("output").value_or("");
  if (made_of.sources.empty()) return error(Errc::usage, "no result folder is given; try 'tessera export --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE");
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();

  BOOST_OUTCOME_TRY(heights, settings.get("z", [](const std::string& text) { return parse_switch(text); }));
  BOOST_OUTCOME_TRY(index, settings.get("index", [](const std::string& text) { return parse_switch(text); }));
  BOOST_OUTCOME_TRY(max_edge, settings.get("max-edge", [](const std::string& text) { return parse_distance(text); }));
  BOOST_OUTCOME_TRY(radius, settings.get("max-radius", [](const std::string& text) { return parse_distance(text); }));
  BOOST_OUTCOME_TRY(local, settings.on("local"));
  BOOST_OUTCOME_TRY(names, settings.get("names", [](const std::string& text) { return parse_names(text); }));
  const ExportOptions options{.format = settings.text("format").value_or(""),
                              .heights = heights.value_or(true),
                              .spatial_index = index.value_or(true),
                              .max_edge = max_edge,
                              .max_radius = radius,
                              .local = local,
                              .names = names.value_or(std::vector<std::string>()),
                              .overwrite = overwrite,
                              .progress = progress_line(output)};

  return on_result(settings, made_of, output, [&](const std::string& folder) -> Status {
    if (names_server(settings)) return export_remotely(settings, folder, target, options, output);
    BOOST_OUTCOME_TRYV(refuse_detach(settings));
    const Interrupt interrupt;
    auto result = export_result(folder, target, options, interrupt.token());
    if (options.progress) std::fprintf(stderr, "\r\x1b[K");
    BOOST_OUTCOME_TRY(exported, std::move(result));
    print_exported(exported, limits_text(settings), output);
    return success();
  });
}

}  // namespace

Command add_export(CLI::App& root) {
  auto command = new_command(
      root, "export", "Writes a result folder as files for other programs",
      "  tessera export out/ -o mesh.ply                 (one file; the ending tells the format)\n"
      "  tessera export out/ -o tiles/ --format vtu      (a folder with one .vtu a tile, and a .pvtu over them)\n"
      "  tessera export ground/ -o ground.gpkg           (2D)\n"
      "  tessera export out/ -o near.vtu --max-edge 2    (without cells that bridge gaps and bays of the hull)\n"
      "  tessera export out/ -o points.h5 --names density    (a row for each point of the input, in its order)\n"
      "  tessera export NAME -o mesh.ply --server http://127.0.0.1:7070      (a result of a daemon, to a file here)\n\n"
      "Formats:\n" +
          export_format_help());
  add_value(command, "format", "NAME", "a format of the list below; default: the format of the ending of --output");
  add_choices(command, "format", export_format_names());
  add_value(command, "output", "PATH",
            "the file to write; a folder, or a name without an ending, gets one file for each tile", 'o', true);
  add_value(command, "max-edge", "LENGTH",
            "leave out cells with a longer edge, in units of the coordinates (2D: in the plane), and vertices that "
            "then have no cell");
  add_value(command, "max-radius", "LENGTH", "leave out cells with a larger circumradius, likewise");
  add_switch(command, "z", "2D: leave out the heights, which otherwise become the third coordinate", 0, false, true);
  add_switch(command, "local",
             "ply, obj, off, stl: write coordinates relative to the lower corner of the result's box, rounded down to "
             "whole numbers; the summary tells this corner. For programs that keep only 32 bits of a coordinate, and "
             "so lose centimetres in national grids");
  add_value(
      command, "names", "NAMES",
      "h5, fits, table, ndnet: which attributes and computed columns of vertices to write, by comma; default: all, "
      "for ndnet density");
  add_switch(command, "index",
             "gpkg: leave out the spatial index; the file is written four times as fast, but maps draw it slowly", 0,
             false, true);
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_remote_options(command);
  add_output_switches(command);
  add_threads_option(command);
  add_memory_option(command, "making a result of point files");
  auto sources = add_sources(command, 0);
  command.run = [settings = command.settings.get(), sources](const std::vector<std::string>& command_line) -> Status {
    return run_export(*settings, {.sources = *sources,
                                  .dimension = 0,
                                  .beside = settings->text("output").value_or(""),
                                  .command_line = command_line});
  };
  return command;
}

}  // namespace tessera::apps
