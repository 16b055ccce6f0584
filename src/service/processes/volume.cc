// The process volume.
#include <filesystem>
#include <optional>
#include <utility>

#include "src/job/report/human.h"
#include "src/result/volume/volume_table.h"
#include "src/result/volume/volumes.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/polygon_text.h"
#include "src/service/processes/product_options.h"
#include "src/service/processes/result_costs.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::optional<proto::Problem> check_options_of_volume(const proto::Inputs& inputs, const JobShare& share) {
  if (auto bad = problem_if(volume_options(inputs.volume(), share))) return bad;
  if (inputs.volume().has_base() || inputs.volume().has_within())
    return check_ending(inputs, {".csv", ".json", ".gpkg"});
  return check_ending(inputs, {".csv", ".json"});
}

std::optional<proto::Problem> check_volume(const Workshop& shop, const proto::Inputs& inputs) {
  for (const auto& [field, name] :
       {std::pair("triangulation", result_read(inputs)), std::pair("second", second_result_read(inputs))}) {
    if (name.empty()) continue;
    const auto manifest = shop.results.manifest(name);
    if (!manifest) return problem_of(manifest.error());
    if (manifest.value()->dimension != 2)
      return problem(400, std::string(field) + ": '" + name + "' is a 3D result, which has no heights over a plane",
                     Errc::usage);
  }
  return std::nullopt;
}

// Writes the polygons of the request, if it has some, and names the file in the options.
Result<std::optional<PolygonText>> write_polygons(const Workshop& shop, const JobWork& work, VolumeOptions& options) {
  const auto& inputs = work.job.inputs().volume();
  if (!inputs.has_base() && !inputs.has_within()) return std::optional<PolygonText>();
  BOOST_OUTCOME_TRY(manifest, shop.results.manifest(inputs.triangulation(), inputs.version()));
  const bool base = inputs.has_base();
  BOOST_OUTCOME_TRY(file, PolygonText::write(work.scratch, base ? "base" : "within",
                                             base ? inputs.base() : inputs.within(), *manifest));
  (base ? options.base : options.within) = file.path();
  return std::optional<PolygonText>(std::move(file));
}

void log_notes(const JobWork& work, const Volumes& made) {
  if (made.long_edges > 0)
    work.log("note: " + grouped(made.long_edges) + " cells with longer edges are left out: holes");
  if (made.without_height > 0)
    work.log("note: " + grouped(made.without_height) +
             " cells have a vertex without a height, and are left out: holes");
  if (!made.note.empty()) work.log("note: " + made.note);
}

Reply<JobDone> run_volume(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().volume();
  auto read = volume_options(inputs, shop.share);
  if (!read) return problem_of(read.error());
  VolumeOptions options = std::move(read).value();
  options.progress = percentage(work);
  const auto polygons = write_polygons(shop, work, options);
  if (!polygons) return problem_of(polygons.error());
  std::optional<std::filesystem::path> second;
  if (!inputs.second().empty()) second = shop.results.folder(inputs.second());
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto made = written_aside(shop, folder, work, [&]() -> Result<Volumes> {
    auto computed =
        volumes(shop.results.folder(inputs.triangulation(), inputs.version()), second, options, work.ledger.token());
    if (!computed && polygons.value()) return polygons.value()->in_callers_words(computed.error());
    if (!computed) return computed.error();
    BOOST_OUTCOME_TRYV(write_volumes(computed.value(), folder / inputs.output()));
    return computed;
  });
  if (!made) return problem_of(made.error());
  log_notes(work, made.value());
  return done_with(folder, to_json(made.value(), folder / inputs.output()), inputs.output());
}

}  // namespace

constinit const Process volume_process{
    .name = "volume",
    .title = "Volumes between surfaces",
    .description =
        "Computes cut and fill from the surface of a 2D result, before, to another one, after: that of a second "
        "result, a level plane, or polygons with heights. Writes a table as .csv or .json, or with polygons also as "
        ".gpkg.",
    .outcome = "The volumes, and the file, by reference",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .check_options = check_options_of_volume,
    .check = check_volume,
    .run = run_volume};

}  // namespace tessera::service
