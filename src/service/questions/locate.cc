// The question locate: which cells have points.
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/job/arguments.h"
#include "src/result/query/answer_text.h"
#include "src/service/live/live_answers.h"
#include "src/service/questions/answer_messages.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {
namespace {

QuestionAnswer location(const OpenQuestion& asked, const Point& p, const std::optional<query::CellDetails>& details,
                        bool final) {
  const auto told = asked.is_part() ? std::optional(final) : std::nullopt;
  final = final && (!details || all_final(details->neighbors));
  if (asked.question.as_message)
    return in_bytes(message_of(p, asked.dimension, details, told).SerializeAsString(), final);
  return {.text = json_of(p, asked.dimension, details, told), .type = json_type, .final = final};
}

Result<std::vector<query::Cell>> cells_at(const OpenQuestion& asked, std::span<const Point> points) {
  if (asked.live) return live_locate(*asked.live, points, asked.ask);
  return asked.reader.stored.locate(points, asked.ask);
}

// The point in the answer is the mean of the cell's corners.
Result<QuestionAnswer> locate_named(const OpenQuestion& asked) {
  const std::string text = asked.word("cell");
  const std::size_t comma = text.find(',');
  const auto tile = parse_integer(text.substr(0, comma), 0, 999'999);
  const auto place = parse_integer(comma == std::string::npos ? "" : text.substr(comma + 1), 0, 0x7fffffff);
  if (!tile || !place || asked.question.options.contains("point"))
    return error(Errc::usage,
                 "cell: must be TILE,CELL, the two numbers of a cell in other answers, and be given without point");
  if (place.value() >= first_in_memory)
    return error(Errc::usage, "cell: a cell in memory has this number in one version only; ask by point");
  BOOST_OUTCOME_TRY(cell, asked.reader.stored.cell(TileId{static_cast<std::uint32_t>(tile.value())},
                                                   static_cast<std::int32_t>(place.value())));
  BOOST_OUTCOME_TRY(details, asked.reader.stored.details(cell));
  const auto& corners = details.vertices;
  Point mean;
  for (int axis = 0; axis < asked.dimension; ++axis) {
    const double first = corners[0].at[axis];
    for (const auto& corner : corners) mean[axis] += (corner.at[axis] - first) / static_cast<double>(corners.size());
    mean[axis] += first;
  }
  return location(asked, without_negative_zero(mean), std::optional(std::move(details)), cell.final);
}

Result<QuestionAnswer> locate_one(const OpenQuestion& asked) {
  if (asked.question.options.contains("cell")) return locate_named(asked);
  const auto at = [&](const std::string& text) { return parse_point(text, asked.dimension); };
  BOOST_OUTCOME_TRY(p, asked.read("point", at));
  BOOST_OUTCOME_TRY(cells, cells_at(asked, {&p, 1}));
  std::optional<query::CellDetails> details;
  if (cells[0]) {
    BOOST_OUTCOME_TRY(found, asked.live ? live_details(*asked.live, cells[0]) : asked.reader.stored.details(cells[0]));
    details = std::move(found);
  }
  return location(asked, p, details, cells[0].final);
}

Result<QuestionAnswer> locate_many(const OpenQuestion& asked) {
  BOOST_OUTCOME_TRY(options, asked.many());
  BOOST_OUTCOME_TRY(answers, TextAnswers::make(options));
  BOOST_OUTCOME_TRY(points, asked.points());
  BOOST_OUTCOME_TRY(cells, cells_at(asked, points));
  const bool final = all_final(cells);
  if (asked.question.as_message) return in_bytes(answers_message(points, cells, options), final);
  BOOST_OUTCOME_TRYV(answers->add_cells(points, cells));
  return finished(*answers, options.format, final);
}

}  // namespace

Result<QuestionAnswer> answer_locate(const OpenQuestion& asked) {
  return asked.question.body ? locate_many(asked) : locate_one(asked);
}

}  // namespace tessera::service
