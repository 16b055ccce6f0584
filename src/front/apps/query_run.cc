#include "src/front/apps/query_run.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/say.h"
#include "src/input/cloud/cloud.h"
#include "src/job/arguments.h"
#include "src/result/query/answer_text.h"
#include "src/result/query/neighbours.h"

namespace tessera::apps {
namespace {

using query::StoredTriangulation;

Result<StoredTriangulation> open(const QueryRequest& request) {
  return StoredTriangulation::open(request.folder,
                                   {.memory_bytes = request.memory_bytes, .parts = true, .periods = Periods::known});
}

Status print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return success();
  return error(Errc::io, "standard output: cannot be written");
}

// Calls `ask` for all points of a cloud, one batch at a time.
template <class Ask>
Status for_all_points(const QueryRequest& request, const std::string& input, int dimension, const Ask& ask) {
  constexpr std::size_t at_once = std::size_t{1} << 20;
  const CloudOptions options{
      .dimension = dimension, .heights = false, .columns = request.columns, .threads = request.ask.threads};
  BOOST_OUTCOME_TRY(cloud, Cloud::open({input}, options, request.ask.stop));
  for (const auto& warning : cloud.warnings()) say_beside("warning: %s\n", warning.c_str());
  std::vector<Point> points;
  const auto answer = [&]() -> Status {
    const Status asked = ask(points);
    points.clear();
    return asked;
  };
  BOOST_OUTCOME_TRY(counts, cloud.for_each_batch([&](CloudBatch& batch) -> Status {
    for (const auto& p : batch.points) points.push_back(p.at);
    return points.size() < at_once ? Status(success()) : answer();
  }));
  if (counts.read == 0) return error(Errc::bad_input, input + ": holds no points");
  return answer();
}

Result<PointId> asked_vertex(const QueryRequest& request, const char* question) {
  const auto id = parse_integer(request.argument, 0, std::numeric_limits<std::int64_t>::max());
  if (id) return PointId{static_cast<std::uint64_t>(id.value())};
  return error(Errc::usage,
               "give the source index of a vertex, as '" + std::string(question) + " 123456': " + id.error().where);
}

}  // namespace

Status query_locate(QueryRequest& request) {
  if (request.argument.empty() == request.points.empty())
    return error(Errc::usage, "give one point, as 'locate 885100,629050', or many by --points FILE");
  BOOST_OUTCOME_TRY(result, open(request));
  const int dimension = result.manifest().dimension;
  if (request.points.empty()) {
    BOOST_OUTCOME_TRY(p, parse_point(request.argument, dimension));
    BOOST_OUTCOME_TRY(cells, result.locate({&p, 1}, request.ask));
    std::optional<query::CellDetails> details;
    if (cells[0]) {
      BOOST_OUTCOME_TRY(found, result.details(cells[0]));
      details = std::move(found);
    }
    const auto final = result.manifest().region ? std::optional(cells[0].final) : std::nullopt;
    return print(request.output.json ? json_of(p, dimension, details, final)
                                     : printable_lines(text_of(p, dimension, details, final)));
  }
  request.answers.dimension = dimension;
  request.answers.final = result.manifest().region.has_value();
  BOOST_OUTCOME_TRY(answers, Answers::open(request.answers));
  BOOST_OUTCOME_TRYV(
      for_all_points(request, request.points, dimension, [&](const std::vector<Point>& points) -> Status {
        BOOST_OUTCOME_TRY(cells, result.locate(points, request.ask));
        return answers->add_cells(points, cells);
      }));
  return answers->finish();
}

Status query_star(QueryRequest& request) {
  BOOST_OUTCOME_TRY(vertex, asked_vertex(request, "star"));
  BOOST_OUTCOME_TRY(result, open(request));
  BOOST_OUTCOME_TRY(star, result.star(vertex, request.tile, request.ask));
  const int dimension = result.manifest().dimension;
  const bool part = result.manifest().region.has_value();
  return print(request.output.json ? json_of(vertex, dimension, star, part)
                                   : printable_lines(text_of(vertex, dimension, star, part)));
}

Status query_neighbours(QueryRequest& request) {
  BOOST_OUTCOME_TRY(vertex, asked_vertex(request, "neighbours"));
  BOOST_OUTCOME_TRY(result, open(request));
  BOOST_OUTCOME_TRY(found, result.neighbours(vertex, request.tile, request.ask));
  const bool part = result.manifest().region.has_value();
  return print(request.output.json ? json_of(found, part) : printable_lines(text_of(found, part)));
}

Status query_cells(QueryRequest& request) {
  if (request.bbox.empty() == request.polygon.empty()) return error(Errc::usage, "give either --bbox or --polygon");
  if (request.target.empty()) return error(Errc::usage, "no file to write is given; add -o FILE");
  BOOST_OUTCOME_TRYV(find_export_target(request.target, request.cells));
  // One half of the memory is for tiles, the other half for the cells that are found in them.
  BOOST_OUTCOME_TRY(result, StoredTriangulation::open(
                                request.folder,
                                {.memory_bytes = request.memory_bytes / 2, .parts = true, .periods = Periods::known}));
  query::Area area;
  if (!request.polygon.empty()) {
    BOOST_OUTCOME_TRY(polygon, query::Polygon::read_geojson(request.polygon));
    BOOST_OUTCOME_TRYV(polygon.place().check_in(result.manifest().crs, result.manifest().bounds));
    constexpr double inf = std::numeric_limits<double>::infinity();
    area.box = polygon.bounds();
    area.box.lo.z = -inf;
    area.box.hi.z = inf;
    area.polygon = std::move(polygon);
  } else {
    auto box = parse_crop(request.bbox, result.manifest().dimension);
    if (!box) return error(Errc::usage, "--bbox: " + box.error().where);
    area.box = {box.value().lo, box.value().hi};
  }
  BOOST_OUTCOME_TRY(set, result.cells(area, {.bytes_max = request.memory_bytes / 2}, request.ask));
  if (set.tiles.empty())
    return error(Errc::usage, request.folder.string() + ": no cell meets " +
                                  (request.polygon.empty() ? "the box " + request.bbox : request.polygon));
  BOOST_OUTCOME_TRY(exported, export_cells(request.folder, result.manifest(), set.mesh, set.tiles, request.target,
                                           request.cells, request.ask.stop));
  print_exported(exported, "", request.output);
  if (!set.final && !request.output.json && !request.output.quiet)
    say_beside(
        "note: this result is a region, and does not know all cells of this place; the answer has the cells that it "
        "knows\n");
  return success();
}

Status query_interpolate(QueryRequest& request) {
  if (request.argument.empty())
    return error(Errc::usage, "no file with points is given; add one, as in 'interpolate points.csv'");
  if (request.value.value.empty())
    return error(Errc::usage,
                 "give the attribute to interpolate, as --value intensity; 2D results have their heights as z");
  BOOST_OUTCOME_TRY(result, open(request));
  const int dimension = result.manifest().dimension;
  request.answers.dimension = dimension;
  request.answers.final = result.manifest().region.has_value();
  request.answers.values = true;
  request.answers.weights = request.value.weights;
  BOOST_OUTCOME_TRY(answers, Answers::open(request.answers));
  BOOST_OUTCOME_TRYV(
      for_all_points(request, request.argument, dimension, [&](const std::vector<Point>& points) -> Status {
        BOOST_OUTCOME_TRY(values, result.interpolate(points, request.value, request.ask));
        return answers->add_values(points, values);
      }));
  return answers->finish();
}

}  // namespace tessera::apps
