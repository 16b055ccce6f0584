// LAS coordinates as the decimals they stand for: X * scale + offset with one rounding instead of three.
#pragma once

#include <cstdint>
#include <memory>

#include "src/base/result.h"

namespace tessera {

// One axis of a LAS file. A scale of 0.01 is stored as the double next to it; what is meant is the decimal. So scale
// and offset are taken to be the shortest decimals that round to the stored doubles, and the coordinate of the integer
// X is the double nearest to the exact decimal value X * scale + offset. Properties:
//  (1) Equal decimal values give equal doubles, whatever scale and offset they are written with: the same point in two
//      files is one point. (X * scale + offset in doubles differs in the last bit for 69 % of the points of lone_star
//      between a file and its COPC twin.)
//  (2) A text file with the same decimals gives the same doubles.
// With S, O, m integers such that scale = S / 10^m and offset = O / 10^m, the value is N / 10^m, N = X * S + O.
class DecimalAxis {
 public:
  // REQUIRES: scale and offset are finite.
  DecimalAxis(double scale, double offset);

  double operator()(std::int32_t integer) const {
    // |N| <= 2^53 and 10^m, m <= 22, are doubles exactly, and so are both steps to N; IEEE division rounds once.
    if (integer >= -fast_max_ && integer <= fast_max_) return (integer * scale_ + offset_) / power_;
    return slowly(integer);
  }
  // True if every 32-bit integer takes the short way.
  bool always_fast() const { return fast_max_ > INT32_MAX; }
  double fast(std::int32_t integer) const { return (integer * scale_ + offset_) / power_; }

 private:
  struct Wide;
  double slowly(std::int32_t integer) const;

  double scale_ = 0, offset_ = 0, power_ = 1;  // S, O, 10^m
  std::int64_t fast_max_ = -1;                 // the short way holds for |X| <= fast_max_
  std::shared_ptr<const Wide> wide_;           // S and O as wide integers, for all others
};

}  // namespace tessera
