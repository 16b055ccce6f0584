// tessera triangulate: makes a result folder from point files.
#include <malloc.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/base/json/json_text.h"
#include "src/front/apps/command.h"
#include "src/front/apps/far_results.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/remote_triangulate.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/watching.h"
#include "src/input/bytes/objects.h"
#include "src/job/job.h"
#include "src/job/open_cloud.h"
#include "src/job/report/progress_display.h"
#include "src/job/report/summary.h"
#include "src/result/far_copy.h"

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

// Makes the result in the folder options.out. Returns nothing when it was finished already. `keeps`: an unfinished run
// stays, for --resume.
Result<std::optional<JobSummary>> make(const TriangulateOptions& options, bool keeps, const std::stop_token& stop) {
  Progress progress;
  BOOST_OUTCOME_TRY(folder, ResultFolder::inspect(options.out, options.resume, options.overwrite));
  ProgressDisplay display(progress, progress_style(options.output), options.output.json ? stdout : stderr);
  const auto open = [&](JobOptions& job, const std::stop_token& by) { return open_cloud(options.inputs, job, by); };
  Engine engine(options.job.threads, options.job.memory_bytes);
  auto summary = run_job(engine, options.job, open, folder, progress, stop);
  display.stop();
  if (summary) return summary;
  if (summary.error().code != Errc::interrupted) {
    folder.abandon();
    return summary.error();
  }
  if (reads_standard_input(options)) {
    folder.abandon();
    return error(Errc::interrupted, "interrupted; standard input cannot be read again, so nothing is kept");
  }
  if (!keeps) {
    folder.abandon();
    return error(Errc::interrupted, "interrupted; nothing is kept");
  }
  const bool resumable = folder.abandon_unless_resumable();
  return error(Errc::interrupted, resumable ? "interrupted; the same command with --resume continues"
                                            : "interrupted while reading the input; nothing is kept");
}

void tell(const TriangulateOptions& options, const std::optional<JobSummary>& made) {
  if (options.output.quiet) return;
  if (!made) {
    say_whole(already_finished(options.out, options.output.json), options.output.json);
    return;
  }
  say_whole(options.output.json ? summary_json(*made) + "\n" : summary_text(*made), options.output.json);
}

// Makes the result in a temporary folder, and sends it to an object store. A result that is made and cannot be sent
// stays here.
Status make_in_store(TriangulateOptions options, const std::stop_token& stop) {
  const std::string name = options.out.string();
  if (options.resume)
    return error(Errc::usage, "--resume continues a run in a folder, and " + name +
                                  " is none; make the result in a folder, and send it with 'tessera upload'");
  BOOST_OUTCOME_TRYV(result::check_far_target(name, options.overwrite, stop));
  BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make());
  options.out = scratch.path() / "result";
  options.job.place = name;
  options.job.resumable = false;
  BOOST_OUTCOME_TRY(made, make(options, false, stop));
  const auto sent = send_to_store(options.out, name, options.overwrite, options.output, stop);
  if (!sent) {
    scratch.keep();
    auto failed = sent.error();
    failed.where += "; the result is in " + options.out.string() + ", and 'tessera upload " + options.out.string() +
                    " -o " + name + "' sends it";
    return failed;
  }
  tell(options, made);
  return success();
}

Status run_triangulate(TriangulateOptions options) {
  const Interrupt interrupt;
  options.job.log = log_debug;
  if (names_object(options.out.string())) return make_in_store(std::move(options), interrupt.token());
  options.job.resumable = !reads_standard_input(options);
  BOOST_OUTCOME_TRY(made, make(options, true, interrupt.token()));
  tell(options, made);
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
                  "  tessera triangulate scan.las -o s3://bucket/folder\n"
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
