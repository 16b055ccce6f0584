#include "src/service/questions/answer_messages.h"

#include <cmath>
#include <cstddef>

namespace tessera::service {
namespace {

void tell(const Point& p, int dimension, google::protobuf::RepeatedField<double>& to) {
  for (int axis = 0; axis < dimension; ++axis) to.Add(p[axis]);
}

void tell(const query::Vertex& vertex, int dimension, proto::Vertex& to) {
  to.set_id(vertex.id.value);
  to.set_tile(vertex.owner.value);
  tell(vertex.at, dimension, *to.mutable_point());
}

// Fills a proto::Cell or, for a point, a proto::Answer.
void tell(const query::Cell& cell, int dimension, auto& to) {
  if (!cell) return;
  to.set_tile(cell.tile.value);
  to.set_cell(static_cast<std::uint32_t>(cell.cell));
  for (int k = 0; k <= dimension; ++k) to.add_vertices(cell.vertices[static_cast<std::size_t>(k)].value);
}

void tell_all(const std::vector<query::Vertex>& list, int dimension, auto& to) {
  for (const auto& vertex : list) tell(vertex, dimension, *to.Add());
}

void tell_all(const std::vector<query::Cell>& list, int dimension, auto& to) {
  for (const auto& cell : list) {
    proto::Cell& told = *to.Add();
    tell(cell, dimension, told);
    if (!cell.final) told.set_final(false);
  }
}

void tell(const query::Cell& cell, const AnswerOptions& options, proto::Answer& to) {
  tell(cell, options.dimension, to);
}

void tell(const query::Interpolated& found, const AnswerOptions& options, proto::Answer& to) {
  if (!std::isnan(found.value)) to.set_value(found.value);
  if (!options.weights) return;
  for (const PointId vertex : found.vertices) to.add_vertices(vertex.value);
  to.mutable_weights()->Add(found.weights.begin(), found.weights.end());
}

template <class Found>
std::string all_of(std::span<const Point> points, std::span<const Found> answers, const AnswerOptions& options) {
  std::string bytes;
  proto::Answers one;  // serialised messages one after the other are one message with all answers
  for (std::size_t i = 0; i < answers.size(); ++i) {
    one.Clear();
    proto::Answer& answer = *one.add_answers();
    tell(points[i], options.dimension, *answer.mutable_point());
    tell(answers[i], options, answer);
    if (options.final) answer.set_final(answers[i].final);
    one.AppendToString(&bytes);
  }
  return bytes;
}

}  // namespace

Result<std::vector<Point>> points_of(std::string_view message, int dimension) {
  const auto bad = [](const std::string& what) { return error(Errc::bad_input, "the body: " + what); };
  proto::Points columns;
  if (!columns.ParseFromArray(message.data(), static_cast<int>(message.size())))
    return bad("is not a protobuf message tessera.proto.Points");
  if (columns.x().empty()) return bad("has no points: its list x is empty");
  const google::protobuf::RepeatedField<double>* lists[] = {&columns.x(), &columns.y(), &columns.z()};
  for (int axis = 1; axis < dimension; ++axis)
    if (lists[axis]->size() != columns.x_size())
      return bad("has " + std::to_string(columns.x_size()) + " values of x, but " +
                 std::to_string(lists[axis]->size()) + " of " + "xyz"[axis]);
  std::vector<Point> points;
  points.reserve(static_cast<std::size_t>(columns.x_size()));
  for (int i = 0; i < columns.x_size(); ++i) {
    Point p;
    for (int axis = 0; axis < dimension; ++axis) p[axis] = lists[axis]->Get(i);
    if (!is_finite(p)) return bad("point " + std::to_string(i) + " has a coordinate that is not finite");
    points.push_back(without_negative_zero(p));
  }
  return points;
}

proto::Location message_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                           std::optional<bool> final) {
  proto::Location told;
  tell(p, dimension, *told.mutable_point());
  if (details) {
    told.set_tile(details->cell.tile.value);
    told.set_cell(static_cast<std::uint32_t>(details->cell.cell));
    tell_all(details->vertices, dimension, *told.mutable_vertices());
    tell_all(details->neighbors, dimension, *told.mutable_neighbors());
  }
  if (final) told.set_final(*final);
  return told;
}

proto::Star message_of(PointId asked, int dimension, const query::Star& star, bool part) {
  proto::Star told;
  told.set_asked(asked.value);
  tell(star.vertex, dimension, *told.mutable_vertex());
  if (std::isfinite(star.voronoi_volume)) told.set_voronoi_volume(star.voronoi_volume);
  told.set_on_hull(std::isinf(star.voronoi_volume));
  tell_all(star.neighbors, dimension, *told.mutable_neighbors());
  tell_all(star.cells, dimension, *told.mutable_cells());
  if (part) told.set_final(star.final);
  return told;
}

proto::Profile message_of(std::span<const ProfilePoint> points) {
  proto::Profile told;
  for (const auto& p : points) {
    proto::ProfilePoint& one = *told.add_points();
    one.set_distance(p.distance);
    one.set_x(p.x);
    one.set_y(p.y);
    if (!std::isnan(p.value)) one.set_value(p.value);
    one.set_part(p.part);
  }
  return told;
}

std::string answers_message(std::span<const Point> points, std::span<const query::Cell> cells,
                            const AnswerOptions& options) {
  return all_of(points, cells, options);
}

std::string answers_message(std::span<const Point> points, std::span<const query::Interpolated> values,
                            const AnswerOptions& options) {
  return all_of(points, values, options);
}

}  // namespace tessera::service
