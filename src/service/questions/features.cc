// The question features: pages of a collection for maps, in longitude and latitude.
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/crs/lon_lat.h"
#include "src/base/crs/storage_crs.h"
#include "src/base/files/names.h"
#include "src/base/option.h"
#include "src/job/arguments.h"
#include "src/result/query/hull.h"
#include "src/result/terrain/line_reader.h"
#include "src/service/beneath.h"
#include "src/service/questions/map_features.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {
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

Result<std::vector<Point>> hull_corners(const OpenQuestion& asked) {
  const std::lock_guard lock(asked.reader.hull->mutex);
  if (!asked.reader.hull->points) {
    BOOST_OUTCOME_TRY(points, query::hull_of(asked.reader.stored.source(), asked.ask.stop));
    asked.reader.hull->points = std::move(points);
  }
  return *asked.reader.hull->points;
}

Result<MapForm> map_form(const OpenQuestion& asked) {
  MapForm form;
  for (const auto& [key, stored] : {std::pair("crs", &MapForm::stored), std::pair("bbox-crs", &MapForm::stored_box)}) {
    const std::string wanted = asked.word(key, crs84_uri);
    if (wanted == crs84_uri) continue;
    BOOST_OUTCOME_TRY(own, storage_crs(asked.reader.stored.manifest().crs));
    if (own.uri.empty() || wanted != own.uri)
      return error(Errc::usage,
                   std::string(key) + ": '" + wanted + "' is not a coordinate system of this collection; there " +
                       (own.uri.empty() ? "is " : "are ") + crs84_uri + (own.uri.empty() ? "" : " and " + own.uri));
    form.*stored = true;
    form.swapped = own.swapped;
  }
  return form;
}

}  // namespace

Result<QuestionAnswer> answer_features(const OpenQuestion& asked) {
  const Manifest& manifest = asked.reader.stored.manifest();
  BOOST_OUTCOME_TRY(places, LonLat::of(manifest.crs));
  BOOST_OUTCOME_TRY(form, map_form(asked));
  std::optional<Bounds> box;
  if (asked.question.options.contains("bbox")) {
    BOOST_OUTCOME_TRY(given, asked.read("bbox", [](const std::string& text) { return parse_crop(text, 3); }));
    box = Bounds{given.lo, given.hi};
    if (form.stored_box && form.swapped) {
      std::swap(box->lo.x, box->lo.y);
      std::swap(box->hi.x, box->hi.y);
    }
  }
  const auto number = [&](const char* key, std::int64_t least, std::int64_t usual) -> Result<std::int64_t> {
    if (!asked.question.options.contains(key)) return usual;
    return asked.read(key, [&](const std::string& text) {
      return parse_integer(text, least, std::numeric_limits<std::int64_t>::max());
    });
  };
  std::optional<std::uint64_t> after;
  BOOST_OUTCOME_TRY(limit, number("limit", 1, limit_usual));
  if (asked.question.options.contains("after")) {
    BOOST_OUTCOME_TRY(last, number("after", 0, 0));
    after = static_cast<std::uint64_t>(last);
  }
  std::optional<std::uint64_t> only;
  if (asked.question.options.contains("item")) {
    const auto item = parse_integer(asked.word("item"), 0, std::numeric_limits<std::int64_t>::max());
    only = item ? static_cast<std::uint64_t>(item.value()) : std::numeric_limits<std::uint64_t>::max();
  }
  FeaturePage page(places, box, static_cast<std::uint64_t>(std::min(limit, limit_max)), form);
  const std::string kind = asked.word("kind");
  std::uint64_t all = 1;
  if (kind == "tiles") {
    all = manifest.tiles.size();
    BOOST_OUTCOME_TRYV(add_tiles(manifest, only, after, page));
  } else if (kind == "hull") {
    BOOST_OUTCOME_TRY(corners, hull_corners(asked));
    if (only.value_or(0) == 0 && !after) {
      const Json properties{{"vertices", manifest.vertices}, {"cells", manifest.cells}, {"corners", corners.size()}};
      BOOST_OUTCOME_TRYV(page.add(0, properties, FeaturePage::Kind::ring, dense_ring(corners)));
    }
  } else {
    const std::uint64_t begin = only && *only > 0 ? *only - 1 : after.value_or(0);
    BOOST_OUTCOME_TRY(lines, add_lines(contours_of_result(path_of(asked.reader.held.folder)), places, box,
                                       form.stored_box, only, begin, asked.ask.stop, page));
    all = lines;
  }
  QuestionAnswer answer{.type = "application/geo+json", .final = !asked.is_part()};
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

}  // namespace tessera::service
