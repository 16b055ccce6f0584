// tessera export: a result folder as a file for other programs.
#include "src/store/export.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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
  auto name = settings.text("format").value_or(target.extension().string());
  if (name.starts_with('.')) name.erase(0, 1);
  if (name.empty()) return error(Errc::usage, "no format is given; add --format ply, vtu, off or geojson");
  auto format = parse_export_format(name);
  if (!format) return error(format.error().code, "--format: " + format.error().where);
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  BOOST_OUTCOME_TRY(output, output_options(settings));
  std::error_code ec;
  if (!overwrite && std::filesystem::is_regular_file(target, ec)) {
    return error(Errc::usage, target.string() + ": exists already; --overwrite replaces it");
  }
  if (output.verbose) log_everything();

  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(exported, export_result(folder, format.value(), target, interrupt.token()));
  if (output.json) {
    const nlohmann::ordered_json object{{"event", "exported"},
                                        {"output", target.string()},
                                        {"vertices", exported.vertices},
                                        {"cells", exported.cells},
                                        {"bytes", exported.bytes}};
    std::printf("%s\n", object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  } else if (!output.quiet) {
    std::printf("%s: %s vertices, %s cells, %s\n", target.c_str(), grouped(exported.vertices).c_str(),
                grouped(exported.cells).c_str(), human_bytes(exported.bytes).c_str());
  }
  return success();
}

}  // namespace

Command add_export(CLI::App& root) {
  auto command =
      new_command(root, "export", "Writes a result folder as a file for other programs",
                  "  tessera export out/ --format ply -o mesh.ply\n"
                  "  tessera export out/ --format vtu -o tiles/      (one .vtu a tile, and a .pvtu over them)\n"
                  "  tessera export ground/ -o ground.geojson        (2D; the ending tells the format)");
  add_value(command, "format", "NAME", "ply, vtu, off or geojson (2D); default: as the ending of --output says");
  add_value(command, "output", "PATH", "the file to write; for vtu also a folder", 'o', true);
  add_switch(command, "overwrite", "replace the file if it exists", 0, true);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  command.app->add_option("result", *folder, "result folder")->type_name("FOLDER");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>&) {
    return run_export(*settings, *folder);
  };
  return command;
}

}  // namespace tessera
