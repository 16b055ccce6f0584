// The process voronoi.
#include "src/result/voronoi/voronoi.h"

#include <optional>
#include <utility>

#include "src/service/processes/job_work.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/polygon_text.h"
#include "src/service/processes/product_options.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::optional<proto::Problem> check_voronoi_options(const proto::Inputs& inputs, const JobShare& share) {
  if (auto bad = problem_if(voronoi_options(inputs.voronoi(), share))) return bad;
  return check_ending(inputs, {".gpkg", ".fgb", ".geojson", ".csv", ".vtu"});
}

Reply<JobDone> run_voronoi(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().voronoi();
  auto options = voronoi_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  std::optional<PolygonText> polygons;
  if (options.value().clip == VoronoiClip::file) {
    const auto manifest = shop.results.manifest(inputs.triangulation(), inputs.version());
    if (!manifest) return problem_of(manifest.error());
    auto file = PolygonText::write(work.scratch, "clip", inputs.clip(), *manifest.value());
    if (!file) return problem_of(file.error());
    polygons.emplace(std::move(file).value());
    options.value().polygons = polygons->path();
  }
  const auto write = [&](const std::filesystem::path& out, const std::filesystem::path& target,
                         const VoronoiOptions& chosen, std::stop_token stop) -> Result<WrittenVoronoi> {
    auto written = write_voronoi(out, target, chosen, std::move(stop));
    if (!written && polygons) return polygons->in_callers_words(written.error());
    return written;
  };
  return draw(shop, work, std::move(options), write);
}

}  // namespace

constinit const Process voronoi_process{
    .name = "voronoi",
    .title = "Voronoi cells",
    .description =
        "Writes the Voronoi cells of the points of a result: of a 2D result as polygons in .gpkg, .fgb, .geojson or "
        ".csv, of a 3D result as polyhedra in .vtu.",
    .outcome = "The file, by reference, and the sum of the areas or volumes",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .check_options = check_voronoi_options,
    .run = run_voronoi};

}  // namespace tessera::service
