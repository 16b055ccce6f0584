// tessera log: lists the versions of a result. The option --version of other commands.
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/front/apps/command.h"
#include "src/front/apps/remote_update.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/update_command.h"
#include "src/front/apps/version_option.h"
#include "src/job/arguments.h"
#include "src/job/describe_versions.h"

namespace tessera::apps {
namespace {

constexpr const char* key = "version";

Status run_log(Settings& settings, const std::string& folder) {
  if (folder.empty()) return error(Errc::usage, "no result folder is given; try 'tessera log --help'");
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  if (names_server(settings)) return log_remotely(settings, folder, json);
  BOOST_OUTCOME_TRY(text, describe_versions(folder, json));
  say_whole(text, json);
  return success();
}

}  // namespace

void add_version_option(Command& command) {
  add_value(command, key, "N", "the version of the result, as 'tessera log' lists them; default: the newest", 0, true);
}

Result<std::string> at_version(const Settings& settings, const std::string& folder) {
  BOOST_OUTCOME_TRY(version, settings.get(key, [](const std::string& text) {
    return parse_integer(text, 1, std::numeric_limits<std::uint32_t>::max());
  }));
  if (!version || names_server(settings)) return folder;
  return version_file(folder, static_cast<std::uint32_t>(*version)).string();
}

std::function<bool(const Error&)> wait_for_lock(std::stop_token stop) {
  return [stop = std::move(stop)](const Error&) {
    constexpr std::chrono::milliseconds pause{100};
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    stopped.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); });
    return !stop.stop_requested();
  };
}

Command add_log(CLI::App& root) {
  auto command = new_command(root, "log", "Lists the versions of a result: when, what changed, how much was written",
                             "  tessera log out/\n"
                             "  tessera log out/ --json\n"
                             "  tessera log NAME --server http://127.0.0.1:7070         (a result of a daemon)\n"
                             "  tessera dem out/ --version 3 --res 1 -o before.tif      (reads an older version)");
  add_switch(command, "json", "one JSON object on stdout, instead of text");
  add_server_options(command);
  auto folder = std::make_shared<std::string>();
  add_argument(command, "result", "FOLDER", *folder, "result folder");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>&) {
    return run_log(*settings, *folder);
  };
  return command;
}

}  // namespace tessera::apps
