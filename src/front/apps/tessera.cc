// The command `tessera`: reads the command line, the environment and the configuration file, runs one subcommand, and
// turns its error into one line on stderr and an exit status (docs/exit-status.md).
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/front/apps/commands.h"
#include "src/front/apps/help.h"
#include "src/front/apps/log.h"
#include "src/front/apps/say.h"
#include "src/front/apps/settings.h"
#include "src/front/apps/words.h"
#include "src/input/bytes/objects.h"
#include "src/input/remote/remote_objects.h"
#include "src/input/remote/url.h"

namespace tessera::apps {
namespace {

int fail(const Error& error, bool json) {
  auto sentence = printable(render(error.where, flag_name));
  sentence.erase(sentence.find_last_not_of(' ') + 1);
  say_beside("tessera: %s\n", sentence.c_str());
  if (json) {
    const nlohmann::ordered_json object{{"event", "error"},
                                        {"status", static_cast<int>(error.code)},
                                        {"message", sentence},
                                        {"options", option_keys(error.where)}};
    std::printf("%s\n", json_text(object).c_str());
    std::fflush(stdout);
  }
  return static_cast<int>(error.code);
}

// How objects are read. Commands without these options go by the environment and ~/.aws alone.
Result<remote::RemoteOptions> remote_options(const Settings& settings) {
  remote::RemoteOptions options;
  options.ca_file = remote::ca_file_of([](const char* name) { return std::getenv(name); });
  if (!settings.knows("endpoint")) return options;
  options.s3.endpoint = settings.text("endpoint").value_or("");
  options.s3.profile = settings.text("profile").value_or("");
  BOOST_OUTCOME_TRY(anonymous, settings.on("anonymous"));
  options.s3.anonymous = anonymous;
  BOOST_OUTCOME_TRY(pays, settings.on("requester-pays"));
  options.s3.requester_pays = pays;
  return options;
}

Status run(const Command& command, const std::vector<Command>& commands, const std::vector<std::string>& command_line) {
  command.settings->load_environment([](const char* name) { return std::getenv(name); });
  const auto file = command.settings->text("config");
  if (file && !file->empty()) {
    std::vector<Settings*> all;
    for (const auto& each : commands) all.push_back(each.settings.get());
    BOOST_OUTCOME_TRYV(load_settings_file(*file, all));
  }
  BOOST_OUTCOME_TRY(remote, remote_options(*command.settings));
  set_objects(remote::remote_objects(std::move(remote)));
  BOOST_OUTCOME_TRYV(command.run(command_line));
  // All output must have been written. Otherwise a pipeline would take half an answer for a whole one.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return error(Errc::io, "standard output: cannot be written");
  return success();
}

// Opens /dev/null for each standard stream that is closed. Otherwise the next file that is opened would get its number,
// and points would be read from that file, or lines written into it. The streams are opened for reading only, so
// writing to a closed stream still fails.
void occupy_standard_streams() {
  int file = 0;
  while (file >= 0 && file <= STDERR_FILENO) file = ::open("/dev/null", O_RDONLY);
  if (file > STDERR_FILENO) ::close(file);
}

// The command line for manifests and reports: addresses without signatures, which are behind '?'.
std::vector<std::string> line_to_keep(int argc, char** argv) {
  std::vector<std::string> line(argv, argv + argc);
  for (auto& word : line)
    if (names_object(word)) word = remote::without_secrets(word);
  return line;
}

int tessera_main(int argc, char** argv) {
  occupy_standard_streams();
  // A write beyond the limit of `ulimit -f` becomes an error with a message, in place of a signal that kills the
  // process.
  std::signal(SIGXFSZ, SIG_IGN);
  start_log();

  CLI::App app;
  const auto commands = add_commands(app);
  std::vector<std::string> names;
  for (const auto& command : commands) names.push_back(command.app->get_name());
  auto arguments = resolve_command(std::vector<std::string>(argv + std::min(argc, 1), argv + argc), names);
  if (!arguments) return fail(arguments.error(), false);
  try {
    std::reverse(arguments.value().begin(), arguments.value().end());  // the parser takes them in reverse order
    app.parse(std::move(arguments).value());
  } catch (const CLI::Success& help) {
    const int status = app.exit(help);
    std::cout.flush();
    return std::cout ? status : fail(error(Errc::io, "standard output: cannot be written"), false);
  } catch (const CLI::ParseError& wrong) {
    const auto chosen = app.get_subcommands();
    const CLI::App& of = chosen.empty() ? app : *chosen.front();
    const std::string name = "tessera" + (chosen.empty() ? "" : " " + of.get_name());
    return fail(error(Errc::usage, wrong_arguments(of, name, wrong) + "; see '" + name + " --help'"), false);
  }
  for (const auto& command : commands) {
    if (!command.app->parsed()) continue;
    const auto status = run(command, commands, line_to_keep(argc, argv));
    if (status) return 0;
    const auto json = command.settings->on("json");
    return fail(status.error(), json && json.value());
  }
  return fail(error(Errc::internal, "no command was run"), false);
}

}  // namespace
}  // namespace tessera::apps

int main(int argc, char** argv) {
  try {
    return tessera::apps::tessera_main(argc, argv);
  } catch (const std::bad_alloc&) {
    return tessera::apps::fail(tessera::error(tessera::Errc::memory, "the system has no more memory to give"), false);
  } catch (const std::exception& e) {
    return tessera::apps::fail(tessera::error(tessera::Errc::internal, std::string("unexpected: ") + e.what()), false);
  }
}
