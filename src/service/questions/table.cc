#include "src/service/questions/table.h"

#include <algorithm>
#include <iterator>

#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {
namespace {

using About = Question::About;

struct QuestionRow {
  About about;
  Result<QuestionAnswer> (*answer)(const OpenQuestion& asked);
};

constexpr QuestionRow table[] = {{About::locate, answer_locate},
                                 {About::star, answer_star},
                                 {About::neighbours, answer_neighbours},
                                 {About::cells, answer_cells},
                                 {About::interpolate, answer_interpolate},
                                 {About::dem, answer_dem},
                                 {About::hull, answer_hull},
                                 {About::section, answer_section},
                                 {About::solids, answer_solids},
                                 {About::contours, answer_contours},
                                 {About::profile, answer_profile},
                                 {About::features, answer_features},
                                 {About::map_tile, answer_map_tile}};

}  // namespace

Result<QuestionAnswer> answer(const OpenQuestion& asked) {
  const auto row = std::find_if(std::begin(table), std::end(table),
                                [&](const QuestionRow& each) { return each.about == asked.question.about; });
  if (row == std::end(table)) return error(Errc::internal, "the question is of an unknown kind");
  return row->answer(asked);
}

}  // namespace tessera::service
