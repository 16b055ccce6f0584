// The question star: what is around a vertex.
#include "src/result/query/answer_text.h"
#include "src/service/live/live_answers.h"
#include "src/service/questions/answer_messages.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {

Result<QuestionAnswer> answer_star(const OpenQuestion& asked) {
  BOOST_OUTCOME_TRY(vertex, asked.vertex());
  BOOST_OUTCOME_TRY(owner, asked.owner());
  BOOST_OUTCOME_TRY(star,
                    asked.live ? live_star(*asked.live, vertex) : asked.reader.stored.star(vertex, owner, asked.ask));
  if (asked.question.as_message)
    return in_bytes(message_of(vertex, asked.dimension, star, asked.is_part()).SerializeAsString(), star.final);
  return QuestionAnswer{
      .text = json_of(vertex, asked.dimension, star, asked.is_part()), .type = json_type, .final = star.final};
}

}  // namespace tessera::service
