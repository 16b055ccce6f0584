// The question map_tile: a tile of pictures, drawn from a result's raster of heights.
#include <algorithm>
#include <string>
#include <utility>

#include "src/base/files/names.h"
#include "src/job/arguments.h"
#include "src/result/terrain/map_tile.h"
#include "src/service/beneath.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {

Result<QuestionAnswer> answer_map_tile(const OpenQuestion& asked) {
  const auto number = [&](const char* key) {
    return asked.read(key, [](const std::string& text) { return parse_integer(text, 0, std::int64_t{1} << 30); });
  };
  terrain::MapTile tile;
  BOOST_OUTCOME_TRY(level, number("level"));
  BOOST_OUTCOME_TRY(row, number("row"));
  BOOST_OUTCOME_TRY(column, number("column"));
  tile = {static_cast<int>(std::min<std::int64_t>(level, terrain::MapTile::levels)), row, column};
  const std::string style = asked.word("style", "hillshade");
  if (style != "hillshade" && style != "terrain-rgb")
    return error(Errc::usage, "style: '" + style + "' is not a style; the styles are hillshade and terrain-rgb");
  if (!tile.exists()) return error(Errc::usage, "the map has no such tile");
  BOOST_OUTCOME_TRY(raster, terrain::HeightRaster::open(dem_of_result(path_of(asked.reader.held.folder))));
  BOOST_OUTCOME_TRY(
      image, raster->draw(tile, style == "hillshade" ? terrain::MapStyle::hillshade : terrain::MapStyle::terrain_rgb));
  return QuestionAnswer{.text = std::move(image), .type = "image/png", .final = !asked.is_part()};
}

}  // namespace tessera::service
