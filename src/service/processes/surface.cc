// The process surface.
#include "src/surface/surface.h"

#include "src/base/files/names.h"
#include "src/base/files/surface_names.h"
#include "src/base/files/there.h"
#include "src/job/engine_steps.h"
#include "src/result/tileset/tileset.h"
#include "src/service/processes/drawing_options.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::string usual_surface(const proto::Inputs& inputs) {
  const bool tileset = inputs.surface().format() == tileset_format;
  return (tileset ? tileset_of_result("") : surface_of_result("")).filename().string();
}

std::optional<proto::Problem> check_surface_options(const proto::Inputs& inputs, const JobShare& share) {
  return problem_if(surface_options(inputs.surface(), share));
}

Reply<JobDone> run_surface(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs();
  auto options = surface_options(inputs.surface(), shop.share);
  if (!options) return problem_of(options.error());
  options.value().output.overwrite = true;  // files of an earlier attempt; existing exports were checked before
  options.value().progress = percentage(work);
  const std::string name = result_read(inputs), output = *export_output(inputs);
  const auto folder = shop.results.unfinished_export(name, work.job.id());
  options.value().resume = true;
  options.value().lock = lock_of_unfinished(shop, work.ledger.token());
  const auto begun = surface_run_folder(folder / output);
  const auto there = is_there(begun);
  if (!there) return problem_of(there.error());
  if (there.value()) work.log("continues the work of an earlier start of this job");
  const auto write = [&] {
    EngineSteps steps(
        shop.engine,
        {.threads = options.value().threads, .memory_bytes = options.value().memory_bytes, .resumable = true},
        work.progress);
    return make_surface(shop.results.folder(name, version_read(inputs)), folder / output, options.value(), steps,
                        work.ledger.token());
  };
  const auto made = written_aside(shop, folder, work, write, begun.filename());
  if (!made) return problem_of(made.error());
  work.log(made.value().sensors);
  if (!made.value().mesh.note.empty()) work.log("note: " + made.value().mesh.note);
  const std::string told = to_json(made.value(), output);
  if (inputs.surface().format() == tileset_format) return done_with_tileset(told, output);
  return done_with(folder, told, output);
}

}  // namespace

constinit const Process surface_process{
    .name = "surface",
    .title = "Surface",
    .description =
        "Makes a closed surface of a 3D result, whose triangles are facets of the triangulation. Without output the "
        "file is called surface.ply.",
    .outcome = "The file, by reference",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .usual_output = usual_surface,
    .check_options = check_surface_options,
    .run = run_surface};

}  // namespace tessera::service
