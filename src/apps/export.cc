// tessera export: a result folder as a file for other programs.
#include "src/export/export.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "src/apps/arguments.h"
#include "src/apps/command.h"
#include "src/apps/interrupt.h"
#include "src/apps/log.h"
#include "src/report/human.h"

namespace tessera {
namespace {

Status run_export(Settings& settings, const std::string& folder) {
  const std::filesystem::path target = settings.text("output").value_or("");
  if (folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera export --help'");
  if (target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE");
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (output.verbose) log_everything();

  BOOST_OUTCOME_TRY(heights, settings.get("z", [](const std::string& text) { return parse_switch(text); }));
  const ExportOptions options{
      .format = settings.text("format").value_or(""), .heights = heights.value_or(true), .overwrite = overwrite};

  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(exported, export_result(folder, target, options, interrupt.token()));
  if (output.json) {
    const nlohmann::ordered_json object{{"event", "exported"},           {"output", target.string()},
                                        {"vertices", exported.vertices}, {"cells", exported.cells},
                                        {"files", exported.files},       {"bytes", exported.bytes},
                                        {"note", exported.note}};
    std::printf("%s\n", object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  } else if (!output.quiet) {
    std::printf("%s: %s vertices, %s cells, %s\n", target.c_str(), grouped(exported.vertices).c_str(),
                grouped(exported.cells).c_str(), human_bytes(exported.bytes).c_str());
    if (!exported.note.empty()) std::fprintf(stderr, "note: %s\n", exported.note.c_str());
  }
  return success();
}

}  // namespace

Command add_export(CLI::App& root) {
  auto command =
      new_command(root, "export", "Writes a result folder as files for other programs",
                  "  tessera export out/ -o mesh.ply                 (one file; the ending tells the format)\n"
                  "  tessera export out/ -o tiles/ --format vtu      (a folder: one .vtu a tile, a .pvtu over them)\n"
                  "  tessera export ground/ -o ground.gpkg           (2D)\n\nFormats:\n" +
                      export_format_help());
  add_value(command, "format", "NAME", "one of those below; default: as the ending of --output says");
  add_value(command, "output", "PATH", "the file to write; a folder, or a name without an ending, gets one file a tile",
            'o', true);
  add_switch(command, "z", "2D: leave out the heights, which else become the third coordinate", 0, false, true);
  add_switch(command, "overwrite", "replace files that exist", 0, true);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  command.app->add_option("result", *folder, "result folder")->type_name("FOLDER");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>&) {
    return run_export(*settings, *folder);
  };
  return command;
}

}  // namespace tessera
