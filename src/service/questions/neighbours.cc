// The question neighbours: which vertices share an edge with a vertex.
#include "src/result/query/neighbours.h"

#include "query.pb.h"
#include "src/service/live/live_answers.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {
namespace {

proto::Neighbours message_of(const query::Neighbours& found, bool part) {
  proto::Neighbours told;
  told.set_asked(found.asked.value);
  told.set_vertex(found.vertex.value);
  told.set_on_hull(found.on_hull);
  for (const PointId id : found.ids) told.add_neighbors(id.value);
  if (part) told.set_final(found.final);
  return told;
}

}  // namespace

Result<QuestionAnswer> answer_neighbours(const OpenQuestion& asked) {
  BOOST_OUTCOME_TRY(vertex, asked.vertex());
  BOOST_OUTCOME_TRY(owner, asked.owner());
  BOOST_OUTCOME_TRY(found, asked.live ? live_neighbours(*asked.live, vertex)
                                      : asked.reader.stored.neighbours(vertex, owner, asked.ask));
  if (asked.question.as_message) return in_bytes(message_of(found, asked.is_part()).SerializeAsString(), found.final);
  return QuestionAnswer{.text = json_of(found, asked.is_part()), .type = json_type, .final = found.final};
}

}  // namespace tessera::service
