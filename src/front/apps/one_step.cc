#include "src/front/apps/one_step.h"

#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/version_option.h"
#include "src/front/apps/watching.h"
#include "src/input/bytes/objects.h"
#include "src/input/cloud/inputs.h"
#include "src/job/job.h"
#include "src/job/open_cloud.h"
#include "src/job/report/progress_display.h"

namespace tessera::apps {

namespace fs = std::filesystem;

namespace {

constexpr const char* kept = "keep-result";

// Returns whether the sources are a result. A folder that does not exist and an unfinished run count as results, so
// that their error messages are those of a result.
Result<bool> is_result(const std::vector<std::string>& sources) {
  if (sources.empty()) return true;
  if (sources.size() > 1) return false;
  if (named_version(sources[0])) return true;
  if (names_object(sources[0])) return is_result_folder(sources[0]);
  const bool names_files = sources[0] == "-" || sources[0].find_first_of("*?[") != std::string::npos;
  BOOST_OUTCOME_TRY(there, is_there(sources[0]));
  if (!there) return !names_files;
  BOOST_OUTCOME_TRY(folder, is_folder(sources[0]));
  if (!folder) return false;
  for (const fs::path& mark : {manifest_file(sources[0]), tiles_folder(sources[0]), run_folder(sources[0])}) {
    BOOST_OUTCOME_TRY(marked, is_there(mark));
    if (marked) return true;
  }
  return false;
}

// Runs `work` with the options, engine, cloud, folder and progress of a job. If `work` fails, removes the folder.
template <class Work>
Status run_in(JobOptions job, const std::vector<std::string>& sources, const fs::path& out, const OutputOptions& output,
              const Work& work) {
  job.store = StoreAs::points;
  job.resumable = false;
  job.log = log_debug;
  const Interrupt interrupt;
  Progress progress;
  BOOST_OUTCOME_TRY(folder, ResultFolder::inspect(out, false, false));
  ProgressDisplay display(progress, progress_style(output), output.json ? stdout : stderr);
  const auto open = [&](JobOptions& options, const std::stop_token& stop) {
    return open_cloud(sources, options, stop);
  };
  Engine engine(job.threads, job.memory_bytes);
  Status worked = work(engine, job, open, folder, progress, interrupt.token());
  display.stop();
  if (!worked) folder.abandon();
  return worked;
}

Result<JobOptions> job_of(Settings& settings, const OneStep& what) {
  JobOptions job;
  BOOST_OUTCOME_TRYV(read_cloud_options(settings, job));
  if (what.dimension != 0) job.cloud.dimension = what.dimension;
  if (what.carry_all && !settings.text("attributes")) job.cloud.attributes = {"all"};
  job.command = what.command_line;
  return job;
}

Status make_result(Settings& settings, const OneStep& what, const fs::path& out, const OutputOptions& output) {
  BOOST_OUTCOME_TRY(job, job_of(settings, what));
  return make_result_of(std::move(job), what.sources, out, output);
}

Status make_product(Settings& settings, const OneStep& what, const fs::path& scratch, const OutputOptions& output,
                    const TileProduct& product) {
  BOOST_OUTCOME_TRY(own, job_of(settings, what));
  own.memory_bytes -= product.memory_bytes;
  return run_in(std::move(own), what.sources, scratch, output,
                [&](Engine& engine, const JobOptions& job, const OpenCloud& open, ResultFolder& folder,
                    Progress& progress, const std::stop_token& stop) -> Status {
                  const auto make = [&](const Manifest& manifest) { return product.make(manifest, stop); };
                  BOOST_OUTCOME_TRYV(run_tiles(engine, job, open, make, folder, progress, stop));
                  return product.finish();
                });
}

// Makes a temporary folder beside the product. Its name differs from the temporary name of the product itself.
Result<TemporaryFolder> folder_beside(const OneStep& what) {
  const fs::path beside = what.beside.empty() ? fs::path("tessera") : fs::path(what.beside);
  if (const fs::path parent = beside.parent_path(); !parent.empty()) {
    BOOST_OUTCOME_TRY(parent_there, is_folder(parent));
    if (!parent_there)
      return error(Errc::io, beside.string() + ": cannot be written: there is no folder " + parent.string());
  }
  return TemporaryFolder::make(temporary_name_of_process(beside.string() + ".result"));
}

}  // namespace

Status make_result_of(JobOptions job, const std::vector<std::string>& sources, const fs::path& out,
                      const OutputOptions& output) {
  return run_in(std::move(job), sources, out, output,
                [](Engine& engine, const JobOptions& options, const OpenCloud& open, ResultFolder& folder,
                   Progress& progress, const std::stop_token& stop) -> Status {
                  BOOST_OUTCOME_TRYV(run_job(engine, options, open, folder, progress, stop));
                  return success();
                });
}

std::shared_ptr<std::vector<std::string>> add_sources(Command& command, int dimension) {
  add_value(command, kept, "FOLDER", "for point files: keep the result that is made of them first, in this folder", 0,
            true);
  add_source_options(command);
  add_version_option(command);
  if (dimension == 0) add_dimension(command);
  auto sources = std::make_shared<std::vector<std::string>>();
  add_argument(command, "result", "FOLDER", *sources,
               "result folder, or point files as for 'tessera triangulate'; with --server, the name of a result");
  return sources;
}

Status on_result(Settings& settings, const OneStep& what, const OutputOptions& output,
                 const std::function<Status(const std::string& folder)>& use) {
  const auto keep = settings.text(kept);
  BOOST_OUTCOME_TRY(there, is_result(what.sources));
  if (names_server(settings) || there) {
    if (what.sources.size() > 1) return error(Errc::usage, "give one result folder, not several");
    if (keep) return error(Errc::usage, "--keep-result is for point files, but " + what.sources[0] + " is a result");
    if (what.sources.empty()) return use("");
    BOOST_OUTCOME_TRY(folder, at_version(settings, what.sources[0]));
    return use(folder);
  }
  if (settings.text("version")) return error(Errc::usage, "--version is for results, but point files are given");
  if (keep) {
    BOOST_OUTCOME_TRYV(make_result(settings, what, *keep, output));
    return use(*keep);
  }
  BOOST_OUTCOME_TRY(folder, folder_beside(what));
  BOOST_OUTCOME_TRYV(make_result(settings, what, folder.path() / "result", output));
  return use((folder.path() / "result").string());
}

Status on_tiles(Settings& settings, const OneStep& what, const OutputOptions& output, const TileProduct& product,
                const std::function<Status(const std::string& folder)>& use) {
  BOOST_OUTCOME_TRY(there, is_result(what.sources));
  if (there || names_server(settings) || settings.text(kept) || settings.text("version"))
    return on_result(settings, what, output, use);
  BOOST_OUTCOME_TRY(folder, folder_beside(what));
  return make_product(settings, what, folder.path() / "run", output, product);
}

}  // namespace tessera::apps
