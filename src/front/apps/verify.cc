// tessera verify: proves that a result folder is right.
#include "src/result/verify/verify.h"

#include <memory>
#include <string>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/machine_options.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/remote_result.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/version_option.h"
#include "src/job/arguments.h"
#include "src/job/engine_steps.h"
#include "src/job/machine.h"
#include "src/job/surface_arguments.h"
#include "src/surface/verify_surface.h"

namespace tessera::apps {
namespace {

Status run_verify_surface(Settings& settings, const std::string& mesh, const VerifyOptions& common,
                          const OutputOptions& output) {
  VerifySurfaceOptions options{.memory_bytes = common.memory_bytes,
                               .scratch = {},
                               .sensors = [](const std::string& text) { return parse_sensors(text, true); }};
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  BOOST_OUTCOME_TRY(scratch, folder_for_temporary(common.scratch));
  options.scratch = scratch;
  if (const auto of = settings.text("of")) {
    BOOST_OUTCOME_TRY(triangulation, at_version(settings, *of));
    options.triangulation = triangulation;
  }
  const Interrupt interrupt;
  Engine engine(options.threads, options.memory_bytes / 2, kinds_of_stages());
  Progress progress;
  EngineSteps steps(engine, {.threads = options.threads, .memory_bytes = options.memory_bytes / 2, .resumable = false},
                    progress);
  BOOST_OUTCOME_TRY(report, verify_surface(mesh, options, steps, interrupt.token()));
  if (output.json) {
    std::printf("%s\n", to_json(report, mesh).c_str());
  } else if (!output.quiet) {
    for (const auto& line : report.passed) say("ok  %s\n", line.c_str());
    if (!report.note.empty()) say("%s\n", report.note.c_str());
  }
  return success();
}

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

  const bool remote = names_server(settings);
  const auto of = settings.text("of");
  if (!remote) {
    BOOST_OUTCOME_TRY(surface, is_surface(folder));
    if (surface) return run_verify_surface(settings, folder, options, output);
  }
  if (of)
    return error(Errc::usage,
                 "--of is for surfaces, but " + folder + " is not a surface that can be checked: it has no .ply");
  if (remote) {
    BOOST_OUTCOME_TRYV(at_version(settings, folder));
    return verify_remotely(settings, folder, output);
  }
  BOOST_OUTCOME_TRYV(refuse_detach(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(version, at_version(settings, folder));
  BOOST_OUTCOME_TRY(report, verify(version, options, interrupt.token()));
  print_verified(folder, report, output);
  return success();
}

}  // namespace

Command add_verify(CLI::App& root) {
  auto command = new_command(
      root, "verify", "Proves that a result folder holds the Delaunay triangulation of its points, or a surface",
      "  tessera verify out/\n"
      "  tessera verify out/ --memory 2G --scratch /data/tmp\n"
      "  tessera verify out/ --against-cgal      (also compares every cell; needs memory for all)\n"
      "  tessera verify mesh.ply --of out/       (a surface: closed, and the minimum cut of out/'s cells)\n"
      "  tessera verify NAME --server http://127.0.0.1:7070      (a result of a daemon, by the daemon)");
  add_switch(command, "against-cgal",
             "also build the global triangulation with CGAL in memory, and compare the sets of cells");
  add_value(command, "memory", "SIZE",
            "memory for facets before they are sorted on disk; default: 70 % of what is available");
  add_value(
      command, "scratch", "FOLDER",
      "the folder in which facets that do not fit into memory are sorted; default: the system's temporary folder");
  add_value(command, "of", "FOLDER",
            "for a surface (a .ply file, or a folder of such files): the 3D result that it was made of; the surface is "
            "made again and compared");
  add_version_option(command);
  add_store_options(command);
  add_threads_option(command);
  add_remote_options(command);
  add_output_switches(command);
  auto folder = std::make_shared<std::string>();
  add_argument(command, "result", "FOLDER", *folder,
               "result folder, also s3://bucket/folder or https://host/folder; with --server, the name of the result");
  command.run = [settings = command.settings.get(), folder](const std::vector<std::string>&) {
    return run_verify(*settings, *folder);
  };
  return command;
}

}  // namespace tessera::apps
