#include "src/terrain/profile.h"

#include <charconv>
#include <cmath>
#include <utility>

#include "src/base/option.h"
#include "src/export/cell_filter.h"
#include "src/query/column.h"
#include "src/terrain/leg_crossings.h"

namespace tessera {
namespace {

// The cells of the surface that the leg meets.
Result<std::vector<terrain::Triangle>> surface(const query::StoredTriangulation& result, const query::Column& column,
                                               const query::Leg& leg, const ProfileOptions& options) {
  query::Area area{.box = {}, .polygon = {}, .leg = leg};
  area.box.add(leg.from);
  area.box.add(leg.to);
  BOOST_OUTCOME_TRY(set, result.cells(area, {.bytes_max = options.memory_bytes}, {.stop = options.stop}));
  const TileMesh& mesh = set.mesh.mesh;
  const std::size_t row_bytes = tessera::row_bytes(set.mesh.schema);
  std::vector<terrain::Triangle> cells;
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (options.max_edge && exports::longest_edge(mesh, i) > *options.max_edge) continue;
    terrain::Triangle cell;
    bool finite = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh.cells[3 * i + k]);
      cell[k] = {mesh.points[v], mesh.ids[v], column.value(set.mesh.rows.data() + v * row_bytes)};
      finite = finite && std::isfinite(cell[k].value);
    }
    if (finite) cells.push_back(cell);
  }
  return cells;
}

void add_number(std::string& to, auto number) {
  char digits[32];
  to.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

}  // namespace

Result<std::vector<ProfilePoint>> profile(const query::StoredTriangulation& result, const std::filesystem::path& out,
                                          std::span<const Point> line, const ProfileOptions& options) {
  const Manifest& manifest = result.manifest();
  if (manifest.dimension != 2)
    return error(Errc::usage, out.string() + ": is a 3D result, which has no heights over a plane; triangulate with " +
                                  option("dim", "2"));
  if (options.max_edge && !(std::isfinite(*options.max_edge) && *options.max_edge > 0))
    return error(Errc::usage, option("max-edge") + ": must be a length, finite and above 0");
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  std::vector<ProfilePoint> points;
  double before = 0;     // length of the legs before
  bool goes_on = false;  // the surface is below where the last leg ended
  std::uint64_t part = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const query::Leg leg{line[i], line[i + 1]};
    if (leg.from == leg.to) continue;
    BOOST_OUTCOME_TRY(cells, surface(result, column, leg, options));
    const auto places = terrain::crossings(leg, cells);
    const double length = std::hypot(leg.to.x - leg.from.x, leg.to.y - leg.from.y);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto& place = places[k];
      const bool at_from = place.part == 0;
      if (k == 0 && goes_on && at_from) continue;  // where the last one ended
      if (!points.empty() && (k == 0 || !places[k - 1].joined)) ++part;
      points.push_back({before + place.part * length, place.at.x, place.at.y, place.value, part});
    }
    goes_on = !places.empty() && places.back().part == 1;
    before += length;
  }
  if (points.empty()) return error(Errc::usage, out.string() + ": the line meets no cell");
  return points;
}

std::string to_csv(std::span<const ProfilePoint> points, const std::string& value) {
  std::string text = "distance,x,y," + value + ",part\n";
  for (const auto& p : points) {
    for (const double number : {p.distance, p.x, p.y, p.value}) {
      add_number(text, number);
      text += ',';
    }
    add_number(text, p.part);
    text += '\n';
  }
  return text;
}

}  // namespace tessera
