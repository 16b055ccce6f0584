// tessera inputs: lists the files that jobs of a daemon may read.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/job_text.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"

namespace tessera::apps {
namespace {

Status run_inputs(Settings& settings, const std::string& folder) {
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(inputs, server.inputs(folder, interrupt.token()));
  if (!json) say("%s", inputs_text(inputs, folder).c_str());
  if (json) {
    for (const auto& input : inputs) print_json_line(input_json(input));
  }
  return success();
}

}  // namespace

Command add_inputs(CLI::App& root) {
  auto command = new_command(root, "inputs", "Lists the point files and folders that jobs of a daemon may read",
                             "  tessera inputs --server http://127.0.0.1:7070\n"
                             "  tessera inputs block --json           (what is in a folder of that list)\n"
                             "  tessera inputs upload:mine            (files that were uploaded)");
  set_group(command, daemon_group);
  add_server_options(command);
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
  auto folder = std::make_shared<std::string>();
  add_argument(command, "folder", "FOLDER", *folder,
               "a folder, as 'tessera inputs' shows it; default: all that the daemon reads");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>&) {
    return run_inputs(*settings, *folder);
  };
  return command;
}

}  // namespace tessera::apps
