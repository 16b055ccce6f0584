// LAS coordinates as exact decimals: X * scale + offset with one rounding instead of three.
#pragma once

#include <cstdint>
#include <memory>

#include "src/base/result.h"

namespace tessera {

// One axis of a LAS file. A file stores the scale 0.01 as the double next to it, but means the decimal. So scale and
// offset are taken as the shortest decimals that round to the stored doubles. The coordinate of the integer X is the
// double nearest to the exact decimal X * scale + offset. Properties:
//  (1) Equal decimal values give equal doubles, whatever the scale and offset of their file. So the same point in two
//      files is one point. (X * scale + offset in doubles differs in the last bit for 69 % of the points of lone_star
//      between a file and its COPC twin.)
//  (2) A text file with the same decimals gives the same doubles.
// Let S, O, m be integers such that scale = S / 10^m and offset = O / 10^m. Then the value is N / 10^m, and N is
// X * S + O. An axis does not change, so threads may share one.
class DecimalAxis {
 public:
  // REQUIRES: scale and offset are finite.
  DecimalAxis(double scale, double offset);

  double operator()(std::int32_t integer) const {
    // |N| <= 2^53 and 10^m with m <= 22 are exact as doubles, and so are both steps to N. The division rounds once.
    if (integer >= -fast_max_ && integer <= fast_max_) return (integer * scale_ + offset_) / power_;
    return slowly(integer);
  }
  // Whether fast() is right for every 32-bit integer.
  bool always_fast() const { return fast_max_ > INT32_MAX; }
  double fast(std::int32_t integer) const { return (integer * scale_ + offset_) / power_; }

 private:
  struct Wide;
  double slowly(std::int32_t integer) const;

  double scale_ = 0, offset_ = 0, power_ = 1;  // S, O, 10^m
  std::int64_t fast_max_ = -1;                 // fast() is right for |X| <= fast_max_
  std::shared_ptr<const Wide> wide_;           // S and O as wide integers, for all other X
};

}  // namespace tessera
