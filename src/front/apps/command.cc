#include "src/front/apps/command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>

namespace tessera::apps {

Command new_command(CLI::App& root, const std::string& name, const std::string& description,
                    const std::string& examples) {
  Command command;
  command.app = root.add_subcommand(name, description)->group("Commands");
  command.app->footer("Examples:\n" + examples);
  command.settings = std::make_unique<Settings>(name);
  add_value(command, "config", "FILE",
            "read options from this TOML file (see config/tessera.toml); default: the file that TESSERA_CONFIG names");
  return command;
}

void add_value(Command& command, const std::string& key, const std::string& metavar, const std::string& help,
               char short_name, bool flag_only) {
  auto* settings = command.settings.get();
  settings->declare(key, flag_only);
  const std::string names = (short_name != 0 ? std::string("-") + short_name + "," : std::string()) + "--" + key;
  command.app
      ->add_option_function<std::string>(
          names, [settings, key](const std::string& text) { settings->set_flag(key, text); }, help)
      ->type_name(metavar);
}

void add_values(Command& command, const std::string& key, const std::string& metavar, std::vector<std::string>& target,
                const std::string& help) {
  command.app->add_option("--" + key, target, help)->type_name(metavar)->allow_extra_args(false)->take_all();
}

void add_switch(Command& command, const std::string& key, const std::string& help, char short_name, bool flag_only,
                bool on_by_default) {
  auto* settings = command.settings.get();
  settings->declare(key, flag_only);
  const std::string short_part = short_name != 0 ? std::string("-") + short_name + "," : std::string();
  auto* on = command.app->add_flag_callback(
      short_part + "--" + key, [settings, key] { settings->set_flag(key, "true"); }, help);
  auto* off = command.app->add_flag_callback(
      "--no-" + key, [settings, key] { settings->set_flag(key, "false"); }, help);
  // The help shows only the form that changes the default.
  (on_by_default ? on : off)->group("");
  on->excludes(off);
}

void add_argument(Command& command, const std::string& name, const std::string& metavar, std::string& target,
                  const std::string& help) {
  command.app->add_option(name, target, help)->type_name(metavar);
}

void add_argument(Command& command, const std::string& name, const std::string& metavar,
                  std::vector<std::string>& target, const std::string& help) {
  command.app->add_option(name, target, help)->type_name(metavar);
}

void set_group(Command& command, const std::string& heading) { command.app->group(heading); }

void add_choices(Command& command, const std::string& key, const std::string& values) {
  auto& list = command.choices[key];
  for (std::size_t at = 0; at < values.size();) {
    const auto end = std::min(values.find(", ", at), values.size());
    list.push_back(values.substr(at, end - at));
    at = end + 2;
  }
}

void add_output_switches(Command& command) {
  add_switch(command, "quiet", "print errors only, no progress and no summary");
  add_switch(command, "verbose", "write a log to stderr", 'v');
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
}

Result<OutputOptions> output_options(Settings& settings) {
  OutputOptions options;
  // Only switches that are on can contradict each other.
  BOOST_OUTCOME_TRY(quiet, settings.on("quiet"));
  BOOST_OUTCOME_TRY(verbose, settings.on("verbose"));
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  if (quiet && verbose) {
    BOOST_OUTCOME_TRYV(settings.exclusive("quiet", "verbose"));
  }
  if (quiet && json) {
    BOOST_OUTCOME_TRYV(settings.exclusive("quiet", "json"));
  }
  const auto stays = [&](bool on, const char* key) { return on && settings.source(key) != Settings::Source::none; };
  options.quiet = stays(quiet, "quiet");
  options.verbose = stays(verbose, "verbose");
  options.json = stays(json, "json");
  return options;
}

}  // namespace tessera::apps
