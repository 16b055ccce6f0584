// The question interpolate: values at points.
#include <string>

#include "src/base/option.h"
#include "src/job/arguments.h"
#include "src/service/questions/answer_messages.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {
namespace {

Result<query::Method> parse_method(const std::string& text) {
  if (text.empty() || text == "linear") return query::Method::linear;
  if (text == "natural") return query::Method::natural;
  return error(Errc::usage, "'" + text + "' is not a method of interpolation; the methods are linear and natural");
}

}  // namespace

Result<QuestionAnswer> answer_interpolate(const OpenQuestion& asked) {
  query::InterpolateOptions what{.value = asked.word("value", asked.dimension == 2 ? "z" : "")};
  if (what.value.empty()) return error(Errc::usage, "value: must name the attribute of the vertices to interpolate");
  BOOST_OUTCOME_TRY(method, asked.read("method", parse_method));
  what.method = method;
  BOOST_OUTCOME_TRY(weights, asked.read("weights", [](const std::string& text) {
    return text.empty() ? Result<bool>(false) : parse_switch(text);
  }));
  what.weights = weights;
  BOOST_OUTCOME_TRY(options, asked.many());
  options.values = true;
  options.weights = weights;
  BOOST_OUTCOME_TRY(answers, TextAnswers::make(options));
  BOOST_OUTCOME_TRY(points, asked.points());
  BOOST_OUTCOME_TRY(values, asked.reader.stored.interpolate(points, what, asked.ask));
  const bool final = all_final(values);
  if (asked.question.as_message) return in_bytes(answers_message(points, values, options), final);
  BOOST_OUTCOME_TRYV(answers->add_values(points, values));
  return finished(*answers, options.format, final);
}

}  // namespace tessera::service
