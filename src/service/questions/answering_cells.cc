// Questions about cells: a cell by its name, and parts of a 3D result for viewers.
#include <cmath>
#include <optional>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/job/arguments.h"
#include "src/result/tileset/shapes.h"
#include "src/service/questions/answering.h"

namespace tessera {

Result<query::CellLimits> Answering::limits_of_cells() const {
  query::CellLimits most{.bytes_max = memory_bytes(), .cells_max = limits_.usual_cells};
  if (!question_.options.contains("limit")) return most;
  const auto number = [&](const std::string& text) {
    return parse_integer(text, 1, static_cast<std::int64_t>(limits_.cells));
  };
  BOOST_OUTCOME_TRY(limit, read("limit", number));
  most.cells_max = static_cast<std::uint64_t>(limit);
  return most;
}

Result<std::optional<double>> Answering::longest_edge() const {
  if (!question_.options.contains("max-edge")) return std::optional<double>();
  BOOST_OUTCOME_TRY(longest, read("max-edge", [](const std::string& text) { return parse_distance(text); }));
  return std::optional(longest);
}

// The point in the answer is the mean of the cell's corners.
Result<QuestionAnswer> Answering::locate_named() const {
  const std::string text = word("cell");
  const std::size_t comma = text.find(',');
  const auto tile = parse_integer(text.substr(0, comma), 0, 999'999);
  const auto place = parse_integer(comma == std::string::npos ? "" : text.substr(comma + 1), 0, 0x7fffffff);
  if (!tile || !place || question_.options.contains("point"))
    return error(Errc::usage, "cell: give TILE,CELL, as other answers name cells, and no point");
  BOOST_OUTCOME_TRY(cell, reader_.stored.cell(TileId{static_cast<std::uint32_t>(tile.value())},
                                              static_cast<std::int32_t>(place.value())));
  BOOST_OUTCOME_TRY(details, reader_.stored.details(cell));
  const auto& corners = details.vertices;
  Point mean;
  for (int axis = 0; axis < dimension_; ++axis) {
    const double first = corners[0].at[axis];
    for (const auto& corner : corners) mean[axis] += (corner.at[axis] - first) / static_cast<double>(corners.size());
    mean[axis] += first;
  }
  return location(without_negative_zero(mean), std::optional(std::move(details)), cell.final);
}

Result<QuestionAnswer> Answering::shown(const tileset::Shape& shape, const query::CellSet& cells) const {
  const auto target = answer_file(folder_, ".glb");
  BOOST_OUTCOME_TRYV(write_whole(target, tileset::to_glb(shape, cells, reader_.stored.manifest())));
  return file(target, cells.final);
}

Status Answering::has_volume() const {
  if (dimension_ == 3) return success();
  return error(Errc::usage, "this is a 2D result: its surface is shown as 3dtiles");
}

Result<QuestionAnswer> Answering::hull() const {
  BOOST_OUTCOME_TRYV(has_volume());
  BOOST_OUTCOME_TRY(most, limits_of_cells());
  BOOST_OUTCOME_TRY(longest, longest_edge());
  BOOST_OUTCOME_TRY(hull, reader_.stored.hull(most, ask_, longest));
  return shown(tileset::hull_shape(hull), hull.set);
}

Result<QuestionAnswer> Answering::section() const {
  BOOST_OUTCOME_TRYV(has_volume());
  BOOST_OUTCOME_TRY(most, limits_of_cells());
  const auto three = [](const std::string& text) { return parse_point(text, 3); };
  BOOST_OUTCOME_TRY(at, read("through", three));
  BOOST_OUTCOME_TRY(normal, read("normal", three));
  const double length = std::hypot(normal.x, normal.y, normal.z);
  if (!(length > 0) || !std::isfinite(length)) return error(Errc::usage, "normal: must have a length");
  query::Area area;
  if (question_.options.contains("bbox")) {
    BOOST_OUTCOME_TRY(box, read("bbox", [](const std::string& text) { return parse_crop(text, 3); }));
    area.box = {box.lo, box.hi};
  } else {
    area.box = reader_.stored.manifest().bounds;
  }
  BOOST_OUTCOME_TRY(longest, longest_edge());
  area.max_edge = longest;
  area.plane = query::Plane{at, {normal.x / length, normal.y / length, normal.z / length}};
  BOOST_OUTCOME_TRY(cells, reader_.stored.cells(area, most, ask_));
  return shown(tileset::section_shape(cells, *area.plane, area.box), cells);
}

Result<QuestionAnswer> Answering::solids() const {
  BOOST_OUTCOME_TRYV(has_volume());
  BOOST_OUTCOME_TRY(most, limits_of_cells());
  BOOST_OUTCOME_TRY(where, area());
  double shrink = 1;
  if (question_.options.contains("shrink")) {
    BOOST_OUTCOME_TRY(part, read("shrink", [](const std::string& text) { return parse_finite(text); }));
    if (part < 0.01 || part > 1) return error(Errc::usage, "shrink: must be from 0.01 to 1");
    shrink = part;
  }
  BOOST_OUTCOME_TRY(longest, longest_edge());
  where.max_edge = longest;
  BOOST_OUTCOME_TRY(cells, reader_.stored.cells(where, most, ask_));
  return shown(tileset::solids_shape(cells, shrink), cells);
}

}  // namespace tessera
