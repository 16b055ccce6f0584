// The process export.
#include "src/result/export/export.h"

#include <utility>

#include "src/result/tileset/tileset.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/result_costs.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

Reply<JobDone> export_tileset(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().export_();
  if (inputs.has_heights() || inputs.has_spatial_index() || inputs.local() || inputs.names_size() > 0)
    return problem(400, "format: 3dtiles cannot be combined with heights, spatial_index, local or names", Errc::usage);
  TilesetOptions options{.memory_bytes = shop.share.memory_bytes, .progress = percentage(work)};
  if (inputs.has_max_edge()) options.max_edge = inputs.max_edge();
  if (inputs.has_max_radius()) options.max_radius = inputs.max_radius();
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto made = written_aside(shop, folder, work, [&] {
    return write_tileset(shop.results.folder(inputs.triangulation(), inputs.version()), folder / inputs.output(),
                         options, work.ledger.token());
  });
  if (!made) return problem_of(made.error());
  return done_with_tileset(to_json(made.value()), inputs.output());
}

Reply<JobDone> run_export(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().export_();
  if (inputs.format() == tileset_format) return export_tileset(shop, work);
  auto options = export_options(inputs);
  if (!options) return problem_of(options.error());
  options.value().overwrite = true;  // files of an earlier attempt; existing exports were checked before
  options.value().progress = percentage(work);
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto exported = written_aside(shop, folder, work, [&] {
    // A name without an ending means a folder of files.
    return export_result(shop.results.folder(inputs.triangulation(), inputs.version()), folder / inputs.output(),
                         options.value(), work.ledger.token());
  });
  if (!exported) return problem_of(exported.error());
  const auto& made = exported.value();
  if (!made.note.empty()) work.log("note: " + made.note);
  const std::string output = made.path.filename().string();
  return done_with(folder, to_json(made, output), output);
}

std::optional<proto::Problem> check_export_options(const proto::Inputs& inputs, const JobShare& /*share*/) {
  return problem_if(export_options(inputs.export_()));
}

Reply<proto::Estimate> estimate_export(const Workshop& shop, const proto::Inputs& inputs,
                                       std::optional<proto::Problem>& refused) {
  const auto manifest = shop.results.manifest(result_read(inputs), version_read(inputs));
  if (!manifest) return problem_of(manifest.error());
  const auto options = export_options(inputs.export_());
  if (!options) return problem_of(options.error());
  proto::Estimate estimate;
  refused =
      check_costs(*manifest.value(), options.value(), inputs.export_().output(), shop.limits, shop.data, estimate);
  return judged(std::move(estimate), refused);
}

}  // namespace

constinit const Process export_process{.name = "export",
                                       .title = "Export",
                                       .description = "Writes a result as a file for other programs.",
                                       .outcome = "The file, by reference",
                                       .reads = Process::Reads::a_result,
                                       .makes = Process::Makes::file,
                                       .costs = Process::Costs::before_it_waits,
                                       .check_options = check_export_options,
                                       .estimate = estimate_export,
                                       .run = run_export};

}  // namespace tessera::service
