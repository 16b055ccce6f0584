// tessera info: tells what is in files or in a result folder, and what triangulating files would take.
#include <cstdio>
#include <memory>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/remote_result.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/version_option.h"
#include "src/front/apps/words.h"
#include "src/job/describe.h"

namespace tessera::apps {
namespace {

Status run_info(Settings& settings, const std::vector<std::string>& what) {
  JobOptions options;
  BOOST_OUTCOME_TRYV(read_cloud_options(settings, options));
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  if (what.empty() && options.cloud.input_list.empty())
    return error(Errc::usage, "neither an input file nor a result folder is given; try 'tessera info --help'");

  std::vector<std::string> named = what;
  if (settings.text("version")) {
    if (what.size() != 1) return error(Errc::usage, "--version is for one result folder");
    BOOST_OUTCOME_TRY(folder, at_version(settings, what[0]));
    named = {folder};
  }
  BOOST_OUTCOME_TRY(counters, settings.on("verbose"));
  if (names_server(settings)) return info_remotely(settings, what, {.json = json, .counters = counters});
  DescribeOptions how{.json = json, .counters = counters, .names = flag_name};
  BOOST_OUTCOME_TRY(statistics, settings.on("stats"));
  how.statistics = statistics;
  const auto described = describe(named, std::move(options), how);
  say_whole(described.text, json);
  if (described.error) return *described.error;
  return success();
}

}  // namespace

Command add_info(CLI::App& root) {
  auto command =
      new_command(root, "info", "Tells what is in input files or a result folder",
                  "  tessera info scan.las\n"
                  "  tessera info block/*.las --memory 4G --threads 8      (what triangulating them would take)\n"
                  "  tessera info block/ --recursive --stats\n"
                  "  tessera info out/ --json\n"
                  "  tessera info NAME --server http://127.0.0.1:7070      (a result or input files of a daemon)");
  add_cloud_options(command);
  add_switch(command, "stats", "read all points, and tell their classes, returns, flags, box and density");
  add_version_option(command);
  add_server_options(command);
  add_switch(command, "verbose", "for a result: print all counters of the run that made it", 'v');
  add_switch(command, "json", "one JSON object on stdout, instead of text");
  auto what = std::make_shared<std::vector<std::string>>();
  add_argument(command, "what", "FILE|FOLDER", *what,
               "input files, folders of them, - for standard input; or one result folder. With --server, the names "
               "that the daemon has for them");
  command.run = [settings = command.settings.get(), what](const std::vector<std::string>&) {
    return run_info(*settings, *what);
  };
  return command;
}

}  // namespace tessera::apps
