// The questions hull, section and solids: parts of a 3D result, for viewers.
#include <cmath>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/job/arguments.h"
#include "src/result/tileset/shapes.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {
namespace {

Result<QuestionAnswer> shown(const OpenQuestion& asked, const tileset::Shape& shape, const query::CellSet& cells) {
  const auto target = answer_file(asked.folder, ".glb");
  BOOST_OUTCOME_TRYV(write_whole(target, tileset::to_glb(shape, cells, asked.reader.stored.manifest())));
  return asked.file(target, cells.final);
}

Status has_volume(const OpenQuestion& asked) {
  if (asked.dimension == 3) return success();
  return error(Errc::usage,
               "this question is for 3D results, and this is a 2D result; export it in the format 3dtiles to view it");
}

}  // namespace

Result<QuestionAnswer> answer_hull(const OpenQuestion& asked) {
  BOOST_OUTCOME_TRYV(has_volume(asked));
  BOOST_OUTCOME_TRY(most, asked.limits_of_cells());
  BOOST_OUTCOME_TRY(sizes, asked.sizes());
  BOOST_OUTCOME_TRY(hull, asked.reader.stored.hull(most, asked.ask, sizes.max_edge, sizes.max_radius));
  return shown(asked, tileset::hull_shape(hull), hull.set);
}

Result<QuestionAnswer> answer_section(const OpenQuestion& asked) {
  BOOST_OUTCOME_TRYV(has_volume(asked));
  BOOST_OUTCOME_TRY(most, asked.limits_of_cells());
  const auto three = [](const std::string& text) { return parse_point(text, 3); };
  BOOST_OUTCOME_TRY(at, asked.read("through", three));
  BOOST_OUTCOME_TRY(normal, asked.read("normal", three));
  const double length = std::hypot(normal.x, normal.y, normal.z);
  if (!(length > 0) || !std::isfinite(length))
    return error(Errc::usage, "normal: must be a vector other than 0,0,0, of finite length");
  query::Area area;
  if (asked.question.options.contains("bbox")) {
    BOOST_OUTCOME_TRY(box, asked.read("bbox", [](const std::string& text) { return parse_crop(text, 3); }));
    area.box = {box.lo, box.hi};
  } else {
    area.box = asked.reader.stored.manifest().bounds;
  }
  BOOST_OUTCOME_TRY(sizes, asked.sizes());
  area.max_edge = sizes.max_edge;
  area.max_radius = sizes.max_radius;
  area.plane = query::Plane{at, {normal.x / length, normal.y / length, normal.z / length}};
  BOOST_OUTCOME_TRY(cells, asked.reader.stored.cells(area, most, asked.ask));
  return shown(asked, tileset::section_shape(cells, *area.plane, area.box), cells);
}

Result<QuestionAnswer> answer_solids(const OpenQuestion& asked) {
  BOOST_OUTCOME_TRYV(has_volume(asked));
  BOOST_OUTCOME_TRY(most, asked.limits_of_cells());
  BOOST_OUTCOME_TRY(where, asked.area());
  double shrink = 1;
  if (asked.question.options.contains("shrink")) {
    BOOST_OUTCOME_TRY(part, asked.read("shrink", [](const std::string& text) { return parse_finite(text); }));
    if (part < 0.01 || part > 1) return error(Errc::usage, "shrink: must be from 0.01 to 1");
    shrink = part;
  }
  BOOST_OUTCOME_TRY(sizes, asked.sizes());
  where.max_edge = sizes.max_edge;
  where.max_radius = sizes.max_radius;
  BOOST_OUTCOME_TRY(cells, asked.reader.stored.cells(where, most, asked.ask));
  return shown(asked, tileset::solids_shape(cells, shrink), cells);
}

}  // namespace tessera::service
