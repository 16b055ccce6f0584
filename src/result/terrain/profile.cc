#include "src/result/terrain/profile.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <utility>

#include "src/base/option.h"
#include "src/result/export/cell_filter.h"
#include "src/result/query/column.h"
#include "src/result/terrain/leg_crossings.h"
#include "src/result/terrain/tiles.h"

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
  const exports::CellFilter filter({options.max_edge, options.max_radius});
  std::vector<terrain::Triangle> cells;
  for (std::size_t i = 0; i < mesh.cell_ghost.size(); ++i) {
    if (!filter.fits(mesh, i)) continue;
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

// Writes up to `decimals` decimals, without trailing zeros; digits_all: the shortest digits that are read back as the
// same double.
void add_number(std::string& to, double number, int decimals) {
  char digits[400];  // a double may have 309 before the point
  char* const end = digits + sizeof digits;
  if (decimals == digits_all) {
    to.append(digits, std::to_chars(digits, end, number).ptr);
    return;
  }
  std::string_view text(digits, std::to_chars(digits, end, number, std::chars_format::fixed, decimals).ptr);
  if (text.find('.') != text.npos) {
    text = text.substr(0, text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.remove_suffix(1);
  }
  to += text == "-0" ? "0" : text;
}

// Four decimals, which survey files rarely exceed, or more for numbers below `usual`, so that they are as precise.
int decimals_of(double most, double usual, int decimals) {
  if (most >= usual || most == 0 || !std::isfinite(most)) return 4;
  return std::min(decimals + std::max(0, -static_cast<int>(std::floor(std::log10(most)))), digits_most);
}

// The decimals of distances and coordinates, and those of values.
std::pair<int, int> decimals_of(std::span<const ProfilePoint> points, int digits) {
  if (digits != digits_of_data) return {digits, digits};
  double farthest = 0, most = 0;
  for (const auto& p : points) {
    farthest = std::max({farthest, std::abs(p.x), std::abs(p.y)});
    most = std::max(most, std::abs(p.value));
  }
  // Nine decimals of a degree are a tenth of a millimetre.
  return {decimals_of(farthest, 1000, 9), decimals_of(most, 1, 4)};
}

}  // namespace

Result<std::vector<ProfilePoint>> profile(const query::StoredTriangulation& result, const std::filesystem::path& out,
                                          std::span<const Point> line, const ProfileOptions& options) {
  const Manifest& manifest = result.manifest();
  BOOST_OUTCOME_TRYV(terrain::check_surface(out, manifest, {options.max_edge, options.max_radius}));
  BOOST_OUTCOME_TRYV(check_digits(options.digits));
  BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, options.value));
  std::vector<ProfilePoint> points;
  double before = 0;     // length of the legs before
  bool goes_on = false;  // the surface continues from the end of the last leg
  std::uint64_t part = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const query::Leg leg{line[i], line[i + 1]};
    if (leg.from == leg.to) continue;
    BOOST_OUTCOME_TRY(cells, surface(result, column, leg, options));
    const auto places = terrain::crossings(leg, cells);
    const double length = std::hypot(leg.to.x - leg.from.x, leg.to.y - leg.from.y);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto& place = places[k];
      const bool at_from = place.fraction == 0;
      if (k == 0 && goes_on && at_from) continue;  // the last leg ended there
      if (!points.empty() && (k == 0 || !places[k - 1].joined)) ++part;
      points.push_back({before + place.fraction * length, place.at.x, place.at.y, place.value, part});
    }
    goes_on = !places.empty() && places.back().fraction == 1;
    before += length;
  }
  if (points.empty()) return error(Errc::usage, out.string() + ": the line meets no cell");
  return points;
}

std::string to_csv(std::span<const ProfilePoint> points, const ProfileOptions& options) {
  const auto [of_places, of_values] = decimals_of(points, options.digits);
  std::string text = "distance,x,y," + options.value + ",part\n";
  for (const auto& p : points) {
    for (const double number : {p.distance, p.x, p.y}) {
      add_number(text, number, of_places);
      text += ',';
    }
    add_number(text, p.value, of_values);
    text += ',' + std::to_string(p.part) + '\n';
  }
  return text;
}

Result<int> parse_digits(const std::string& text) {
  if (text == "all") return digits_all;
  if (text == "data") return digits_of_data;
  int digits = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), digits);
  if (failed != std::errc() || end != text.data() + text.size() || digits < 0 || digits > digits_most)
    return error(Errc::usage, "'" + text + "' is not a number of decimals from 0 to " + std::to_string(digits_most) +
                                  ", all or data");
  return digits;
}

Status check_digits(int digits) {
  if (digits < digits_all || digits > digits_most)
    return error(Errc::usage, option("digits") + ": must be from 0 to " + std::to_string(digits_most));
  return success();
}

ProfileGaps gaps_of(std::span<const ProfilePoint> points, std::span<const Point> line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i)
    length += std::hypot(line[i].x - line[i - 1].x, line[i].y - line[i - 1].y);
  const auto gap = [&](double from, double to) { return to - from > 1e-9 * length ? to - from : 0; };
  ProfileGaps gaps{.before = gap(0, points.front().distance), .after = gap(points.back().distance, length)};
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].part == points[i - 1].part) continue;
    gaps.between += gap(points[i - 1].distance, points[i].distance);
    ++gaps.count;
  }
  return gaps;
}

std::string gaps_note(const ProfileGaps& gaps) {
  const auto length = [](double number) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.6g", number);
    return std::string(digits);
  };
  std::string note;
  const auto add = [&](const std::string& what) { note += (note.empty() ? "the surface " : ", ") + what; };
  if (gaps.before > 0) add("begins " + length(gaps.before) + " after the line's beginning");
  if (gaps.after > 0) add("ends " + length(gaps.after) + " before its end");
  if (gaps.count > 0)
    add("has " + std::to_string(gaps.count) + (gaps.count == 1 ? " gap" : " gaps") + " of " + length(gaps.between) +
        (gaps.count == 1 ? "" : " together"));
  return note;
}

}  // namespace tessera
