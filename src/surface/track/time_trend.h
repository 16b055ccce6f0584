// Straight lines through values over time, by weighted least squares.
#pragma once

#include <span>
#include <vector>

namespace tessera {

// The times and weights of n observations. One object serves several lists of values at the same times. Takes no copy:
// the spans must live as long as the object, and keep their values.
class TimeTrend {
 public:
  struct Line {
    double at_zero = 0, speed = 0;  // the value at the time 0, and the change of the value in a unit of time
  };

  // REQUIRES: n > 0; as many weights as times; weights are above 0.
  TimeTrend(std::span<const double> times, std::span<const double> weights);

  // Returns the line that fits n values best. If all times are equal, the line is level, at the mean of the values.
  Line line(std::span<const double> values) const;
  // Returns the values without their line.
  std::vector<double> rest(std::span<const double> values) const;
  // Returns the weighted sum of the products of n values and n others.
  double sum(std::span<const double> a, std::span<const double> b) const;
  double weight() const { return weight_; }  // of all observations together

 private:
  std::span<const double> times_, weights_;
  double weight_ = 0, middle_ = 0;  // the weighted mean of the times
  double spread_ = 0;               // the weighted sum of the squared distances from it
};

}  // namespace tessera
