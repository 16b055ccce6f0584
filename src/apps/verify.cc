// tessera verify: proves a result folder.
#include "src/verify/verify.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "src/apps/command.h"
#include "src/apps/interrupt.h"
#include "src/apps/log.h"
#include "src/apps/outcome.h"
#include "src/apps/remote_result.h"
#include "src/apps/server_options.h"
#include "src/job/arguments.h"
#include "src/job/machine.h"

namespace tessera {
namespace {

Status run_verify(Settings& settings, const std::string& folder) {
  VerifyOptions options;
  BOOST_OUTCOME_TRY(memory, settings.get("memory", or_auto([](const std::string& text) { return parse_memory(text); },
                                                           default_memory())));
  options.memory_bytes = memory.value_or(default_memory());
  options.scratch = settings.text("scratch").value_or("");
  BOOST_OUTCOME_TRY(against_cgal, settings.on("against-cgal"));
  options.against_cgal = against_cgal;
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera verify --help'");
  if (output.verbose) log_everything();

  if (names_server(settings)) return verify_remotely(settings, folder, output);
  BOOST_OUTCOME_TRYV(refuse_detach(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(report, verify(folder, options, interrupt.token()));
  print_verified(folder, report, output);
  return success();
}

}  // namespace

Command add_verify(CLI::App& root) {
  auto command =
      new_command(root, "verify", "Proves that a result folder holds the Delaunay triangulation of its points",
                  "  tessera verify out/\n"
                  "  tessera verify out/ --memory 2G --scratch /data/tmp\n"
                  "  tessera verify out/ --against-cgal      (also compares every cell; needs memory for all)\n"
                  "  tessera verify NAME --server http://127.0.0.1:7070      (a result of a daemon, by the daemon)");
  add_switch(command, "against-cgal",
             "also build the global triangulation with CGAL in memory, and compare the sets of cells");
  add_value(command, "memory", "SIZE",
            "memory for facets before they are sorted on disk; default: 70 % of what is available");
  add_value(command, "scratch", "FOLDER", "where to sort what does not fit; default: the system's temporary folder");
  add_remote_options(command);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  command.app->add_option("result", *folder, "result folder; with --server, the name of the result")
      ->type_name("FOLDER");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>&) {
    return run_verify(*settings, *folder);
  };
  return command;
}

}  // namespace tessera
