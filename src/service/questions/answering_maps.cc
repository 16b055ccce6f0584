// Answers for maps: features in longitude and latitude, and tiles of pictures.
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/crs/lon_lat.h"
#include "src/base/crs/storage_crs.h"
#include "src/base/files/names.h"
#include "src/base/option.h"
#include "src/job/arguments.h"
#include "src/result/query/hull.h"
#include "src/result/terrain/line_reader.h"
#include "src/result/terrain/map_tile.h"
#include "src/service/questions/answering.h"
#include "src/service/beneath.h"
#include "src/service/questions/map_features.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t limit_usual = 10, limit_max = 10'000;

Status add_tiles(const Manifest& manifest, const std::optional<std::uint64_t>& only,
                 const std::optional<std::uint64_t>& after, FeaturePage& page) {
  for (const auto& entry : manifest.tiles) {
    if ((only && *only != entry.tile.value) || (after && entry.tile.value <= *after)) continue;
    const Bounds box = query::box_of(manifest, entry.tile);
    const Point corners[] = {
        {box.lo.x, box.lo.y, 0}, {box.hi.x, box.lo.y, 0}, {box.hi.x, box.hi.y, 0}, {box.lo.x, box.hi.y, 0}};
    Json properties{{"tile", entry.tile.value},
                    {"vertices", entry.own_points},
                    {"cells", entry.main_cells},
                    {"bytes", entry.bytes}};
    if (manifest.dimension == 3) {
      properties["lowest"] = box.lo.z;
      properties["highest"] = box.hi.z;
    }
    BOOST_OUTCOME_TRY(more, page.add(entry.tile.value, properties, FeaturePage::Kind::ring, dense_ring(corners)));
    if (!more) break;
  }
  return success();
}

// Adds contour lines to the page, from number `begin` on; `only`: adds that line alone. Returns how many the file has.
Result<std::uint64_t> add_lines(const std::filesystem::path& file, const LonLat& places,
                                const std::optional<Bounds>& box, bool stored_box, std::optional<std::uint64_t> only,
                                std::uint64_t begin, const std::stop_token& stop, FeaturePage& page) {
  BOOST_OUTCOME_TRY(lines, terrain::LineReader::open(file));
  const bool heights = lines->value_name() == "elevation";
  std::optional<Bounds> near;
  if (box && stored_box) {
    near = box;
  } else if (box) {
    // What is beyond the coordinates of the result is in no line's box.
    const auto own = places.box_from(*box);
    if (own) near = own.value();
  }
  BOOST_OUTCOME_TRYV(lines->for_each(begin, near, [&](terrain::LineReader::Line& line) -> Result<bool> {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while reading lines");
    if (only && line.number != *only) return false;
    Json properties{{lines->value_name(), line.value}};
    if (line.index) properties["index"] = *line.index;
    return page.add(line.number, properties, FeaturePage::Kind::line, std::move(line.points),
                    heights ? std::optional(line.value) : std::nullopt);
  }));
  return lines->lines();
}

}  // namespace

Result<std::vector<Point>> Answering::hull_corners() const {
  const std::lock_guard lock(reader_.hull->mutex);
  if (!reader_.hull->points) {
    BOOST_OUTCOME_TRY(points, query::hull_of(reader_.stored.source(), ask_.stop));
    reader_.hull->points = std::move(points);
  }
  return *reader_.hull->points;
}

Result<MapForm> Answering::map_form() const {
  MapForm form;
  for (const auto& [key, stored] : {std::pair("crs", &MapForm::stored), std::pair("bbox-crs", &MapForm::stored_box)}) {
    const std::string asked = word(key, crs84_uri);
    if (asked == crs84_uri) continue;
    BOOST_OUTCOME_TRY(own, storage_crs(reader_.stored.manifest().crs));
    if (own.uri.empty() || asked != own.uri)
      return error(Errc::usage, std::string(key) + ": '" + asked + "' is no system of this collection; there " +
                                    (own.uri.empty() ? "is " : "are ") + crs84_uri +
                                    (own.uri.empty() ? "" : " and " + own.uri));
    form.*stored = true;
    form.swapped = own.swapped;
  }
  return form;
}

Result<QuestionAnswer> Answering::features() const {
  const Manifest& manifest = reader_.stored.manifest();
  BOOST_OUTCOME_TRY(places, LonLat::of(manifest.crs));
  BOOST_OUTCOME_TRY(form, map_form());
  std::optional<Bounds> box;
  if (question_.options.contains("bbox")) {
    BOOST_OUTCOME_TRY(asked, read("bbox", [](const std::string& text) { return parse_crop(text, 3); }));
    box = Bounds{asked.lo, asked.hi};
    if (form.stored_box && form.swapped) {
      std::swap(box->lo.x, box->lo.y);
      std::swap(box->hi.x, box->hi.y);
    }
  }
  const auto number = [&](const char* key, std::int64_t least, std::int64_t usual) -> Result<std::int64_t> {
    if (!question_.options.contains(key)) return usual;
    return read(key, [&](const std::string& text) {
      return parse_integer(text, least, std::numeric_limits<std::int64_t>::max());
    });
  };
  std::optional<std::uint64_t> after;
  BOOST_OUTCOME_TRY(limit, number("limit", 1, limit_usual));
  if (question_.options.contains("after")) {
    BOOST_OUTCOME_TRY(last, number("after", 0, 0));
    after = static_cast<std::uint64_t>(last);
  }
  std::optional<std::uint64_t> only;
  if (question_.options.contains("item")) {
    const auto item = parse_integer(word("item"), 0, std::numeric_limits<std::int64_t>::max());
    only = item ? static_cast<std::uint64_t>(item.value()) : std::numeric_limits<std::uint64_t>::max();
  }
  FeaturePage page(places, box, static_cast<std::uint64_t>(std::min(limit, limit_max)), form);
  const std::string kind = word("kind");
  std::uint64_t all = 1;
  if (kind == "tiles") {
    all = manifest.tiles.size();
    BOOST_OUTCOME_TRYV(add_tiles(manifest, only, after, page));
  } else if (kind == "hull") {
    BOOST_OUTCOME_TRY(corners, hull_corners());
    if (only.value_or(0) == 0 && !after) {
      const Json properties{{"vertices", manifest.vertices}, {"cells", manifest.cells}, {"corners", corners.size()}};
      BOOST_OUTCOME_TRYV(page.add(0, properties, FeaturePage::Kind::ring, dense_ring(corners)));
    }
  } else {
    const std::uint64_t begin = only && *only > 0 ? *only - 1 : after.value_or(0);
    BOOST_OUTCOME_TRY(lines, add_lines(contours_of_result(path_of(reader_.held.folder)), places, box, form.stored_box,
                                       only, begin, ask_.stop, page));
    all = lines;
  }
  QuestionAnswer answer{.type = "application/geo+json", .final = !is_part()};
  if (only) {
    answer.text = page.take();
    if (!answer.text.empty()) answer.text.pop_back();
    return answer;
  }
  if (page.full()) answer.next = page.last();
  answer.text = "{\"type\":\"FeatureCollection\",";
  if (!box) answer.text += "\"numberMatched\":" + std::to_string(all) + ",";
  answer.text += "\"numberReturned\":" + std::to_string(page.count()) + ",\"features\":[" + page.take() + "]";
  return answer;
}

Result<QuestionAnswer> Answering::map_tile() const {
  const auto number = [&](const char* key) {
    return read(key, [](const std::string& text) { return parse_integer(text, 0, std::int64_t{1} << 30); });
  };
  terrain::MapTile tile;
  BOOST_OUTCOME_TRY(level, number("level"));
  BOOST_OUTCOME_TRY(row, number("row"));
  BOOST_OUTCOME_TRY(column, number("column"));
  tile = {static_cast<int>(std::min<std::int64_t>(level, terrain::MapTile::levels)), row, column};
  const std::string style = word("style", "hillshade");
  if (style != "hillshade" && style != "terrain-rgb")
    return error(Errc::usage, "style: '" + style + "' is no style; there are hillshade and terrain-rgb");
  if (!tile.exists()) return error(Errc::usage, "the map has no such tile");
  BOOST_OUTCOME_TRY(raster, terrain::HeightRaster::open(dem_of_result(path_of(reader_.held.folder))));
  BOOST_OUTCOME_TRY(
      image, raster->draw(tile, style == "hillshade" ? terrain::MapStyle::hillshade : terrain::MapStyle::terrain_rgb));
  return QuestionAnswer{.text = std::move(image), .type = "image/png", .final = !is_part()};
}

}  // namespace tessera
