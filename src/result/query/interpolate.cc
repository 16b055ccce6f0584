#include "src/result/query/interpolate.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "src/result/query/batch.h"
#include "src/result/query/column.h"
#include "src/result/query/natural.h"
#include "src/result/query/opened_result.h"

namespace tessera::query {

Result<std::vector<Interpolated>> interpolated(const OpenedResult& result, std::span<const Point> points,
                                               const InterpolateOptions& what, const AskOptions& options) {
  if (what.method == Method::natural) {
    BOOST_OUTCOME_TRYV(result.refuse_periods("questions for natural neighbours"));
  }
  BOOST_OUTCOME_TRY(column, find_column(result.out, result.manifest, what.value));
  const std::vector<Point> asked = result.in_box(points);
  std::vector<Interpolated> values(points.size());
  const auto visit = [&](Walker& walker, std::size_t i, const Located& located) -> Status {
    Interpolated& answer = values[i];
    answer.final = located.final;
    if (!located.place) {
      answer.value = std::numeric_limits<double>::quiet_NaN();
      return success();
    }
    std::vector<Weight> weights;
    if (what.method == Method::natural) {
      walker.forget_doubts();
      BOOST_OUTCOME_TRY(natural, natural_weights(walker, located, asked[i]));
      weights = std::move(natural);
      answer.final = answer.final && !walker.met_unknown() && !walker.met_unsure();
      if (walker.met_unknown()) {  // some of its natural neighbours are unknown
        answer.value = std::numeric_limits<double>::quiet_NaN();
        return success();
      }
    }
    if (weights.empty()) weights = linear_weights(located, asked[i]);
    long double value = 0;
    for (const Weight& weight : weights) {
      if (weight.weight == 0) continue;  // the value does not count, and may be NaN
      value += weight.weight * column.value(weight.tile->row(weight.vertex));
      if (!what.weights) continue;
      answer.vertices.push_back(weight.id());
      answer.weights.push_back(static_cast<double>(weight.weight));
    }
    answer.value = static_cast<double>(value);
    return success();
  };
  const Batch batch{.points = asked, .threads = options.threads, .with_rows = true, .stop = options.stop};
  BOOST_OUTCOME_TRYV(result.locate(batch, visit));
  return values;
}

}  // namespace tessera::query
