#include "src/surface/track/time_trend.h"

#include <cstddef>

#include "src/base/ieee_arithmetic.h"

namespace tessera {

TimeTrend::TimeTrend(std::span<const double> times, std::span<const double> weights)
    : times_(times), weights_(weights) {
  for (std::size_t i = 0; i < times.size(); ++i) {
    weight_ += weights[i];
    middle_ += weights[i] * times[i];
  }
  middle_ /= weight_;
  for (std::size_t i = 0; i < times.size(); ++i) {
    spread_ += weights[i] * (times[i] - middle_) * (times[i] - middle_);
  }
}

TimeTrend::Line TimeTrend::line(std::span<const double> values) const {
  double v = 0, tv = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    v += weights_[i] * values[i];
    tv += weights_[i] * (times_[i] - middle_) * values[i];
  }
  const double speed = spread_ > 0 ? tv / spread_ : 0;
  return {v / weight_ - speed * middle_, speed};
}

std::vector<double> TimeTrend::rest(std::span<const double> values) const {
  const auto [at_zero, speed] = line(values);
  std::vector<double> rest(values.begin(), values.end());
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= at_zero + speed * times_[i];
  return rest;
}

double TimeTrend::sum(std::span<const double> a, std::span<const double> b) const {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += weights_[i] * a[i] * b[i];
  return sum;
}

}  // namespace tessera
