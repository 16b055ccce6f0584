// tessera triangulate: makes a result folder from point files.
#include <malloc.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/remote_triangulate.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/watching.h"
#include "src/job/job.h"
#include "src/job/open_cloud.h"
#include "src/job/report/progress_display.h"
#include "src/job/report/summary.h"

namespace tessera::apps {
namespace {

// Makes malloc return more memory to the system, for jobs with little memory. By default each thread has a pool of its
// own, which returns little, and freed blocks are kept for later: 10 to 25 MiB that no budget shows. Jobs with more
// memory have room for that.
void spare_memory(std::uint64_t memory_bytes) {
  if (memory_bytes >= std::uint64_t{1} << 30) return;
  mallopt(M_ARENA_MAX, 2);
  mallopt(M_MMAP_THRESHOLD, 256 << 10);
}

// Returns the output of --resume if nothing is left to do.
std::string already_finished(const std::filesystem::path& out, bool json) {
  if (!json) return out.string() + ": is finished already, there is nothing to resume\n";
  const nlohmann::ordered_json line{{"event", "finished"}, {"output", out.string()}};
  return json_text(line) + "\n";
}

Status run_triangulate(TriangulateOptions options) {
  const Interrupt interrupt;
  Progress progress;
  BOOST_OUTCOME_TRY(folder, ResultFolder::inspect(options.out, options.resume, options.overwrite));
  ProgressDisplay display(progress, progress_style(options.output), options.output.json ? stdout : stderr);
  options.job.log = log_debug;
  options.job.resumable = !reads_standard_input(options);
  const auto open = [&](JobOptions& job, const std::stop_token& stop) { return open_cloud(options.inputs, job, stop); };
  Engine engine(options.job.threads, options.job.memory_bytes);
  const auto summary = run_job(engine, options.job, open, folder, progress, interrupt.token());
  display.stop();
  if (!summary) {
    if (summary.error().code != Errc::interrupted) {
      folder.abandon();
      return summary.error();
    }
    if (reads_standard_input(options)) {
      folder.abandon();
      return error(Errc::interrupted, "interrupted; standard input cannot be read again, so nothing is kept");
    }
    const bool resumable = folder.abandon_unless_resumable();
    return error(Errc::interrupted, resumable ? "interrupted; the same command with --resume continues"
                                              : "interrupted while reading the input; nothing is kept");
  }
  if (options.output.quiet) return success();
  if (!summary.value()) {
    say_whole(already_finished(folder.path(), options.output.json), options.output.json);
    return success();
  }
  const JobSummary& figures = *summary.value();
  say_whole(options.output.json ? summary_json(figures) + "\n" : summary_text(figures), options.output.json);
  return success();
}

}  // namespace

Command add_triangulate(CLI::App& root) {
  auto command =
      new_command(root, "triangulate", "Triangulates point files into a result folder",
                  "  tessera triangulate block/*.las -o out/\n"
                  "  tessera triangulate a.las b.ply -o out/ --memory 4G --threads 8\n"
                  "  tessera triangulate block/ --recursive -o out/      (the point files in a folder)\n"
                  "  zcat scan.xyz.gz | tessera triangulate - -o out/\n"
                  "  tessera triangulate city.copc.laz -o out/ --crop 885000,629000,885200,629200 --resolution 0.5\n"
                  "  tessera triangulate scan.las -o ground/ --dim 2 --class 2,9 --attributes intensity\n"
                  "  tessera triangulate huge.las -o out/ --resume      (after Ctrl-C or a crash)\n"
                  "  tessera triangulate block/*.las -o block --server http://127.0.0.1:7070      (by a daemon)");
  add_triangulate_options(command);
  add_remote_options(command);
  auto inputs = std::make_shared<std::vector<std::string>>();
  add_argument(
      command, "inputs", "FILE", *inputs,
      "LAS, LAZ, COPC, EPT, PLY, E57, PCD, PTX, PTS, OFF, OBJ, STL, XYZ/CSV or NPY files, also as .gz or .zst; folders "
      "of them; patterns of "
      "their names; - for standard input");
  command.run = [settings = command.settings.get(), inputs](const std::vector<std::string>& command_line) -> Status {
    BOOST_OUTCOME_TRY(options, read_triangulate_options(*settings, *inputs));
    if (options.output.verbose) log_everything();
    if (names_server(*settings)) return triangulate_remotely(*settings, options);
    BOOST_OUTCOME_TRYV(refuse_detach(*settings));
    spare_memory(options.job.memory_bytes);
    options.job.command = command_line;
    return run_triangulate(std::move(options));
  };
  return command;
}

}  // namespace tessera::apps
