#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "src/crs/crs.h"
#include "src/job/describe.h"
#include "src/report/human.h"
#include "src/store/tile_store.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

std::string as_json(const std::string& folder, const Manifest& manifest) {
  Json tiles = Json::array(), inputs = Json::array(), names = Json::array();
  for (const auto& tile : manifest.tiles) {
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
  return Json{{"result", folder},
              {"format_version", manifest.format_version},
              {"software_version", manifest.software_version},
              {"command", manifest.command},
              {"inputs", inputs},
              {"dimension", manifest.dimension},
              {"crs", manifest.crs},
              {"crs_name", crs_title(manifest.crs)},
              {"bounds", {{"min", {box.lo.x, box.lo.y, box.lo.z}}, {"max", {box.hi.x, box.hi.y, box.hi.z}}}},
              {"partition", manifest.partition_kind},
              {"points", manifest.points_read},
              {"invalid", manifest.invalid},
              {"filtered", manifest.filtered},
              {"duplicates", manifest.duplicates},
              {"vertices", manifest.vertices},
              {"cells", manifest.cells},
              {"digest", manifest.digest ? Json(digest_text(*manifest.digest)) : Json()},
              {"neighbors", manifest.neighbors},
              {"attributes", names},
              {"seconds", manifest.seconds},
              {"figures", manifest.figures},
              {"tiles", tiles}}
             .dump(-1, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

// Figures carry their unit at the end of their name.
std::string figure(const std::string& name, double value) {
  if (name.ends_with("_s")) return human_seconds(value);
  const bool count = value >= 0 && value < 1e18;
  if (count && name.ends_with("_bytes")) return human_bytes(static_cast<std::uint64_t>(value));
  return count && value == std::floor(value) ? grouped(static_cast<std::uint64_t>(value)) : coordinate(value);
}

std::string as_text(const std::string& folder, const Manifest& manifest) {
  std::string text = folder + "\n";
  const auto line = [&](std::string name, const std::string& value) {
    name.resize(20, ' ');
    text += "  " + name + value + "\n";
  };
  std::uint64_t bytes = 0, least = ~std::uint64_t{0}, most = 0;
  for (const auto& tile : manifest.tiles) {
    bytes += tile.bytes;
    least = std::min(least, tile.own_points);
    most = std::max(most, tile.own_points);
  }
  const auto side = [](double lo, double hi) { return coordinate(lo) + " .. " + coordinate(hi); };
  const auto& box = manifest.bounds;
  line("made by", "Tessera " + manifest.software_version + " from " + grouped(manifest.inputs.size()) +
                      (manifest.inputs.size() == 1 ? " file" : " files"));
  line("points", grouped(manifest.points_read) + ", " + grouped(manifest.duplicates) + " duplicates, " +
                     grouped(manifest.invalid) + " invalid, " + grouped(manifest.filtered) + " filtered out");
  line("vertices", grouped(manifest.vertices));
  line(manifest.dimension == 3 ? "tetrahedra" : "triangles", grouped(manifest.cells));
  line("box", side(box.lo.x, box.hi.x) + "   " + side(box.lo.y, box.hi.y) +
                  (manifest.dimension == 3 ? "   " + side(box.lo.z, box.hi.z) : ""));
  line("tiles", grouped(manifest.tiles.size()) + " (" + manifest.partition_kind + ")" +
                    (manifest.tiles.empty() ? "" : ", " + grouped(least) + " to " + grouped(most) + " vertices each"));
  line("size", human_bytes(bytes) + (manifest.neighbors ? "" : ", without neighbours"));
  if (manifest.digest) line("digest", digest_text(*manifest.digest));
  std::string names;
  for (const auto& attribute : manifest.schema) names += (names.empty() ? "" : ", ") + attribute.name;
  line("attributes", names.empty() ? "none" : names);
  if (!manifest.crs.empty()) line("CRS", crs_title(manifest.crs));
  for (const auto& [name, seconds] : manifest.seconds) line(name, human_seconds(seconds));
  for (const auto& [name, value] : manifest.figures) line(name, figure(name, value));
  return text;
}

}  // namespace

Result<std::string> describe_result(const std::string& folder, bool json) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(folder));
  return json ? as_json(folder, manifest) : as_text(folder, manifest);
}

}  // namespace tessera
