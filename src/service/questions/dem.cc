// The question dem: the surface of a 2D result as a raster.
#include <string>

#include "src/base/files/names.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"
#include "src/result/terrain/dem.h"
#include "src/result/terrain/grid.h"
#include "src/service/beneath.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {

Result<QuestionAnswer> answer_dem(const OpenQuestion& asked) {
  DemOptions options{.memory_bytes = asked.memory_bytes(), .threads = asked.ask.threads};
  BOOST_OUTCOME_TRY(res, asked.read("res", [](const std::string& text) { return parse_distance(text); }));
  options.res = res;
  BOOST_OUTCOME_TRYV(asked.read_surface(options));
  const std::string type = asked.word("type", "float32");
  if (type != "float32" && type != "float64")
    return error(Errc::usage, "type: '" + type + "' is not a type of pixels; the types are float32 and float64");
  options.doubles = type == "float64";
  const std::string name = asked.word("method", "linear");
  const auto method = dem_method_of(name);
  if (!method)
    return error(Errc::usage, "method: '" + name + "' is not a method; the methods are linear, natural and laplace");
  options.method = *method;
  const Bounds& bounds = asked.reader.stored.manifest().bounds;
  BOOST_OUTCOME_TRY(grid, terrain::grid_over(options.res, options.box.value_or(bounds), bounds));
  const auto pixels = static_cast<std::uint64_t>(grid.width) * static_cast<std::uint64_t>(grid.height);
  if (pixels > asked.limits.pixels)
    return error(Errc::memory, "the raster would have " + grouped(static_cast<std::uint64_t>(grid.width)) + " x " +
                                   grouped(static_cast<std::uint64_t>(grid.height)) +
                                   " pixels, and an answer may have " + grouped(asked.limits.pixels) +
                                   " at most: ask for a smaller bbox or a larger res");
  // The box of the pixels' centres: cells that contain no centre have no pixels. The cells of a small box come from few
  // tiles. When there are too many for memory, all tiles are read one after the other.
  const query::Area area{
      .box = {{grid.centre(grid.column0), grid.centre(grid.row0), 0},
              {grid.centre(grid.column0 + grid.width - 1), grid.centre(grid.row0 + grid.height - 1), 0}},
      .polygon = std::nullopt};
  const auto folder = path_of(asked.reader.held.folder);
  const auto target = answer_file(asked.folder, ".tif");
  const Manifest& manifest = asked.reader.stored.manifest();
  auto cells = manifest.dimension == 2 ? asked.reader.stored.cells(area, {.bytes_max = asked.memory_bytes()}, asked.ask)
                                       : Result<query::CellSet>(query::CellSet{});
  if (!cells && cells.error().code != Errc::memory) return cells.error();
  BOOST_OUTCOME_TRY(drawn, cells ? write_dem_of(folder, manifest, cells.value().mesh, target, options, asked.ask.stop)
                                 : write_dem(folder, target, options, asked.ask.stop));
  return asked.file(drawn.path, asked.reader.stored.knows(area.box));
}

}  // namespace tessera::service
