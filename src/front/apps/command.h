// One subcommand: its options and what it does. Each has a file of its own that offers add_NAME().
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/settings.h"

namespace CLI {
class App;
}

namespace tessera {

struct Command {
  CLI::App* app = nullptr;  // belongs to the root
  std::unique_ptr<Settings> settings;
  std::map<std::string, std::vector<std::string>> choices;  // of an option's or argument's value, for completion
  // Checks all arguments, then acts. `command_line`: for the manifest.
  std::function<Status(const std::vector<std::string>& command_line)> run;
};

Command add_triangulate(CLI::App& root);
Command add_verify(CLI::App& root);
Command add_info(CLI::App& root);
Command add_export(CLI::App& root);
Command add_region(CLI::App& root);
Command add_query(CLI::App& root);
Command add_dem(CLI::App& root);
Command add_surface(CLI::App& root);
Command add_tileset(CLI::App& root);
Command add_track(CLI::App& root);
Command add_materialise(CLI::App& root);
Command add_measure(CLI::App& root);
Command add_columns(CLI::App& root);
Command add_certs(CLI::App& root);
Command add_cluster(CLI::App& root);
Command add_jobs(CLI::App& root);
Command add_job(CLI::App& root);
Command add_watch(CLI::App& root);
Command add_cancel(CLI::App& root);
Command add_resume(CLI::App& root);
Command add_results(CLI::App& root);
Command add_inputs(CLI::App& root);
Command add_fetch(CLI::App& root);
Command add_upload(CLI::App& root);
Command add_nodes(CLI::App& root);
Command add_drain(CLI::App& root);
Command add_generate(CLI::App& root);
Command add_harness(CLI::App& root);

// Under which the help lists commands that ask a daemon.
constexpr const char* daemon_group = "Asking a daemon (--server)";
// Its argument: the id of a job.
std::shared_ptr<std::string> add_job_id(Command& command);

// The parts of a command's declaration that all share.
Command new_command(CLI::App& root, const std::string& name, const std::string& description,
                    const std::string& examples);
// --key VALUE (and -short VALUE), TESSERA_KEY, key = in the file.
void add_value(Command& command, const std::string& key, const std::string& metavar, const std::string& help,
               char short_name = 0, bool flag_only = false);
// --key and --no-key. With on_by_default `help` tells what the latter does.
void add_switch(Command& command, const std::string& key, const std::string& help, char short_name = 0,
                bool flag_only = false, bool on_by_default = false);
// A positional argument: one word, or all that follow.
void add_argument(Command& command, const std::string& name, const std::string& metavar, std::string& target,
                  const std::string& help);
void add_argument(Command& command, const std::string& name, const std::string& metavar,
                  std::vector<std::string>& target, const std::string& help);
// The heading under which the help of all commands lists this one.
void set_group(Command& command, const std::string& heading);
// What the value of that option or argument can be: "kdtree, grid".
void add_choices(Command& command, const std::string& key, const std::string& values);
void add_output_switches(Command& command);  // quiet, verbose, json

struct OutputOptions {
  bool quiet = false, verbose = false, json = false;
};
Result<OutputOptions> output_options(Settings& settings);

}  // namespace tessera
