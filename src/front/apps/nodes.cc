// tessera nodes and drain: list the nodes that work on a daemon's jobs, and take all work from one of them.
#include <cstdio>
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

Status run_nodes(Settings& settings) {
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(nodes, server.nodes(interrupt.token()));
  if (!json) say("%s", nodes_text(nodes).c_str());
  if (json) {
    for (const auto& node : nodes) print_json_line(node_json(node));
  }
  return success();
}

Status run_drain(Settings& settings, const std::string& name) {
  if (name.empty()) return error(Errc::usage, "no node is given; 'tessera nodes' lists them");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(node, server.drain(name, interrupt.token()));
  if (output.json) {
    print_json_line(node_json(node));
  } else if (!output.quiet) {
    say("node %s takes no more work, and its tiles go to other nodes; %s\n", name.c_str(),
        node.coordinator() ? "its process goes on as the coordinator" : "its process ends");
  }
  return success();
}

}  // namespace

Command add_nodes(CLI::App& root) {
  auto command = new_command(root, "nodes", "Lists the nodes that work on a daemon's jobs",
                             "  tessera nodes --server http://127.0.0.1:7070\n"
                             "  tessera nodes --json");
  set_group(command, daemon_group);
  add_server_options(command);
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
  command.run = [settings = command.settings.get()](const std::vector<std::string>&) { return run_nodes(*settings); };
  return command;
}

Command add_drain(CLI::App& root) {
  auto command = new_command(root, "drain", "Takes all work from a node of a cluster, whose process then ends",
                             "  tessera drain beta --server http://127.0.0.1:7070\n"
                             "  tessera drain beta --quiet");
  set_group(command, daemon_group);
  add_server_options(command);
  add_output_switches(command);
  auto name = std::make_shared<std::string>();
  add_argument(command, "node", "NODE", *name, "its name or id, as 'tessera nodes' shows them");
  command.run = [settings = command.settings.get(), name](const std::vector<std::string>&) {
    return run_drain(*settings, *name);
  };
  return command;
}

}  // namespace tessera::apps
