// Converts questions and answers to messages (proto/query.proto), with the same content as in JSON
// (src/result/query/answer_text.h, answers.h).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "query.pb.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/answers.h"
#include "src/result/query/stored_triangulation.h"
#include "src/result/terrain/profile.h"

namespace tessera::service {

// The points of a proto::Points. In 2D their z is 0. Errors, all bad_input, which call the message the body: no such
// message, no points, lists of different lengths, a number that is not finite.
Result<std::vector<Point>> points_of(std::string_view message, int dimension);

proto::Location message_of(const Point& p, int dimension, const std::optional<query::CellDetails>& details,
                           std::optional<bool> final = {});
proto::Star message_of(PointId asked, int dimension, const query::Star& star, bool part = false);
proto::Profile message_of(std::span<const ProfilePoint> points);

// The bytes of a proto::Answers. The message is never in memory as a whole, which would take several times as much. Of
// the options, dimension, weights and final are used.
std::string answers_message(std::span<const Point> points, std::span<const query::Cell> cells,
                            const AnswerOptions& options);
std::string answers_message(std::span<const Point> points, std::span<const query::Interpolated> values,
                            const AnswerOptions& options);

}  // namespace tessera::service
