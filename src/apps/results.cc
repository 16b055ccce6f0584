// tessera results and fetch: what a daemon has made.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/apps/command.h"
#include "src/apps/interrupt.h"
#include "src/apps/job_text.h"
#include "src/apps/log.h"
#include "src/apps/server_options.h"
#include "src/client/fetch.h"
#include "src/report/human.h"

namespace tessera {
namespace {

Status run_results(Settings& settings) {
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(results, server.triangulations(interrupt.token()));
  if (!json) std::fputs(results_text(results).c_str(), stdout);
  if (json) {
    for (const auto& result : results) print_json_line(result_json(result));
  }
  return success();
}

// A line on the terminal, redrawn when its percentage changes; nothing elsewhere.
std::function<void(const FetchProgress&)> progress_line(const OutputOptions& output) {
  if (output.quiet || output.json || output.verbose || isatty(STDERR_FILENO) == 0) return [](const FetchProgress&) {};
  return [shown = -1](const FetchProgress& now) mutable {
    if (now.bytes_total == 0) return;
    const int percent = static_cast<int>(100.0 * static_cast<double>(now.bytes) / static_cast<double>(now.bytes_total));
    if (percent == shown) return;
    shown = percent;
    std::fprintf(stderr, "\r\x1b[Kfetching %d %% of %s", percent, human_bytes(now.bytes_total).c_str());
  };
}

Status run_fetch(Settings& settings, const std::string& name) {
  const std::filesystem::path folder = settings.text("output").value_or("");
  if (name.empty()) return error(Errc::usage, "no result is given; 'tessera results' lists them");
  if (folder.empty()) return error(Errc::usage, "no folder is given; add -o FOLDER");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  if (output.verbose) log_everything();
  const Interrupt interrupt;
  auto result = fetch_result(server, name, folder, progress_line(output), interrupt.token());
  if (isatty(STDERR_FILENO) != 0 && !output.quiet) std::fprintf(stderr, "\r\x1b[K");
  if (!result && result.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; the same command goes on");
  BOOST_OUTCOME_TRY(fetched, std::move(result));
  if (output.json) {
    print_json_line({{"event", "fetched"},
                     {"result", name},
                     {"output", folder.string()},
                     {"files", fetched.files},
                     {"bytes", fetched.bytes},
                     {"vertices", fetched.vertices},
                     {"cells", fetched.cells},
                     {"tiles", fetched.tiles}});
  } else if (!output.quiet) {
    std::printf("%s: %s vertices, %s cells, %s tiles, %s\n", folder.c_str(), grouped(fetched.vertices).c_str(),
                grouped(fetched.cells).c_str(), grouped(fetched.tiles).c_str(), human_bytes(fetched.bytes).c_str());
  }
  return success();
}

}  // namespace

Command add_results(CLI::App& root) {
  auto command = new_command(root, "results", "Lists the results that a daemon has",
                             "  tessera results --server http://127.0.0.1:7070\n"
                             "  tessera results --json");
  command.app->group(daemon_group);
  add_server_options(command);
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
  command.run = [settings = command.settings.get()](const std::vector<std::string>&) { return run_results(*settings); };
  return command;
}

Command add_fetch(CLI::App& root) {
  auto command = new_command(root, "fetch", "Copies a result of a daemon into a folder here, and checks every file",
                             "  tessera fetch NAME -o out/ --server http://127.0.0.1:7070\n"
                             "  tessera fetch NAME -o out/      (again, after Ctrl-C: goes on where it was)");
  command.app->group(daemon_group);
  add_value(command, "output", "FOLDER", "the result folder: new, empty, or what an earlier fetch has left", 'o', true);
  add_server_options(command);
  add_output_switches(command);
  auto name = std::make_shared<std::string>();
  command.app->add_option("result", *name, "its name, as 'tessera results' shows it")->type_name("NAME");
  command.run = [settings = command.settings.get(), name](const std::vector<std::string>&) {
    return run_fetch(*settings, *name);
  };
  return command;
}

}  // namespace tessera
