#include <cmath>
#include <nlohmann/json.hpp>

#include "src/base/crs/crs.h"
#include "src/job/describe.h"
#include "src/job/describe_columns.h"
#include "src/job/describe_units.h"
#include "src/job/description.h"
#include "src/result/store/period.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const std::string& folder, const Manifest& manifest) {
  Json tiles = Json::array(), inputs = Json::array(), names = Json::array();
  std::uint64_t of_points = 0;
  for (const auto& tile : manifest.tiles) {
    of_points += tile.kind == TileKind::points ? 1 : 0;
    tiles.push_back({{"tile", tile.tile.value},
                     {"points", tile.own_points},
                     {"foreign_points", tile.points - tile.own_points},
                     {"cells", tile.main_cells},
                     {"bytes", tile.bytes},
                     {"digest", tile.digest ? Json(digest_text(*tile.digest)) : Json()}});
  }
  for (const auto& input : manifest.inputs) inputs.push_back({{"path", input.path}, {"bytes", input.bytes}});
  for (const auto& attribute : manifest.schema) names.push_back(attribute.name);
  const auto& box = manifest.bounds;
  const auto heights = heights_of(manifest);
  Json region;
  const auto& part = manifest.region;
  if (part) {
    const auto finite = [](double v) { return std::isfinite(v) ? Json(v) : Json(); };
    const auto corner = [&](const Point& p) { return Json{finite(p.x), finite(p.y), finite(p.z)}; };
    region = Json{{"min", corner(part->box.lo)}, {"max", corner(part->box.hi)}, {"complete", part->complete}};
  }
  Json described{
      {"result", folder},
      {"format_version", manifest.format_version},
      {"software_version", manifest.software_version},
      {"command", manifest.command},
      {"inputs", inputs},
      {"dimension", manifest.dimension},
      {"crs", manifest.crs},
      {"crs_name", crs_title(manifest.crs)},
      {"bounds", {{"min", {box.lo.x, box.lo.y, box.lo.z}}, {"max", {box.hi.x, box.hi.y, box.hi.z}}}},
      {"heights", heights ? Json{{"min", heights->lo}, {"max", heights->hi}} : Json()},
      {"partition", manifest.partition_kind},
      {"period", is_periodic(manifest) ? Json(period_of(manifest).length) : Json()},
      {"points", manifest.points_read},
      // A region does not count these: what it does not need was not read.
      {"invalid", part ? Json() : Json(manifest.invalid)},
      {"filtered", part ? Json() : Json(manifest.filtered)},
      {"duplicates", part ? Json() : Json(manifest.duplicates)},
      {"duplicates_at_other_heights", !part && manifest.other_heights ? Json(*manifest.other_heights) : Json()},
      {"keep", name_of(manifest.keep)},
      {"vertices", manifest.vertices},
      {"cells", manifest.cells},
      {"digest", manifest.digest ? Json(digest_text(*manifest.digest)) : Json()},
      {"region", region},
      {"neighbors", manifest.neighbors},
      {"tiles_of_points", of_points},
      {"attributes", names},
      {"version", manifest.version},
      {"columns", columns_to_json(manifest)},
      {"seconds", manifest.seconds},
      {"figures", manifest.figures},
      {"tiles", tiles}};
  if (Json units = units_of(manifest.unit, manifest.schema); !units.empty()) described["units"] = std::move(units);
  return described;
}

}  // namespace

Result<std::string> describe_result(const std::string& folder, bool json, bool counters) {
  BOOST_OUTCOME_TRY(source, TileSource::open(folder, Periods::known));
  return written(to_json(folder, source.manifest()), json, counters);
}

}  // namespace tessera
