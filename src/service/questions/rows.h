// The questions, each answered in a file of its own. Errors: as OpenQuestion's.
#pragma once

#include "src/base/result.h"
#include "src/service/questions/questions_backend.h"

namespace tessera::service {

class OpenQuestion;

Result<QuestionAnswer> answer_cells(const OpenQuestion& asked);
Result<QuestionAnswer> answer_contours(const OpenQuestion& asked);
Result<QuestionAnswer> answer_dem(const OpenQuestion& asked);
Result<QuestionAnswer> answer_features(const OpenQuestion& asked);
Result<QuestionAnswer> answer_hull(const OpenQuestion& asked);
Result<QuestionAnswer> answer_interpolate(const OpenQuestion& asked);
Result<QuestionAnswer> answer_locate(const OpenQuestion& asked);
Result<QuestionAnswer> answer_map_tile(const OpenQuestion& asked);
Result<QuestionAnswer> answer_neighbours(const OpenQuestion& asked);
Result<QuestionAnswer> answer_profile(const OpenQuestion& asked);
Result<QuestionAnswer> answer_section(const OpenQuestion& asked);
Result<QuestionAnswer> answer_solids(const OpenQuestion& asked);
Result<QuestionAnswer> answer_star(const OpenQuestion& asked);

}  // namespace tessera::service
