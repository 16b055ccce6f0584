// One subcommand: its options and what it does. Each subcommand has a file of its own with a function add_NAME().
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

namespace tessera::apps {

// A subcommand as it is declared.
struct Command {
  CLI::App* app = nullptr;  // owned by the root
  std::unique_ptr<Settings> settings;
  std::map<std::string, std::vector<std::string>>
      choices;  // by option or argument: the possible values, for completion
  // Checks all arguments, then does the work. `command_line` is for the manifest.
  std::function<Status(const std::vector<std::string>& command_line)> run;
};

Command add_triangulate(CLI::App& root);
Command add_verify(CLI::App& root);
Command add_info(CLI::App& root);
Command add_export(CLI::App& root);
Command add_region(CLI::App& root);
Command add_query(CLI::App& root);
Command add_dem(CLI::App& root);
Command add_hag(CLI::App& root);
Command add_voids(CLI::App& root);
Command add_voronoi(CLI::App& root);
Command add_volume(CLI::App& root);
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

// The heading under which the help lists commands that ask a daemon.
constexpr const char* daemon_group = "Asking a daemon (--server)";
// Adds the argument ID, the id of a job. Returns the string that gets it.
std::shared_ptr<std::string> add_job_id(Command& command);

// The functions below are the parts of which declarations of commands consist.
Command new_command(CLI::App& root, const std::string& name, const std::string& description,
                    const std::string& examples);
// Adds an option with a value: --key VALUE (and -short VALUE), the variable TESSERA_KEY, and key = in the file.
// flag_only: only the flag.
void add_value(Command& command, const std::string& key, const std::string& metavar, const std::string& help,
               char short_name = 0, bool flag_only = false);
// The same for an option that may be given several times; only the flag.
void add_values(Command& command, const std::string& key, const std::string& metavar, std::vector<std::string>& target,
                const std::string& help);
// Adds a switch: --key and --no-key. With on_by_default, `help` describes --no-key.
void add_switch(Command& command, const std::string& key, const std::string& help, char short_name = 0,
                bool flag_only = false, bool on_by_default = false);
// Adds a positional argument: one word (string), or all words that follow (vector).
void add_argument(Command& command, const std::string& name, const std::string& metavar, std::string& target,
                  const std::string& help);
void add_argument(Command& command, const std::string& name, const std::string& metavar,
                  std::vector<std::string>& target, const std::string& help);
// Sets the heading under which the help of the program lists this command.
void set_group(Command& command, const std::string& heading);
// Tells completion the possible values of an option or argument: "kdtree, grid".
void add_choices(Command& command, const std::string& key, const std::string& values);
void add_output_switches(Command& command);  // --quiet, --verbose, --json

struct OutputOptions {
  bool quiet = false, verbose = false, json = false;
};
Result<OutputOptions> output_options(Settings& settings);

}  // namespace tessera::apps
