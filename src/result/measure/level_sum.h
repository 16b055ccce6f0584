// Sums of long doubles whose bits do not depend on the order of their terms.
//
// A term is cut at fixed places, which are 32 bits apart, by rounding it to multiples of the place. A sum keeps the
// highest places that any of its terms has reached, `levels` of them; what is lower is dropped. At each place there are
// multiples of it, so additions there are exact. What is kept of a term is the term, rounded to a multiple of the
// lowest place, and this place depends only on the greatest term. Source: Demmel, Nguyen, Parallel reproducible
// summation, IEEE Transactions on Computers 64 (2015). An OrderFreeSum takes less memory, and more than twice the time.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tessera {

// REQUIRES: fewer than 2^30 terms.
template <std::size_t levels>
class LevelSum {
 public:
  void add(long double term) {
    if (!(std::fabs(term) < limit_)) reach(term);
    long double near = limit_ * (1.5L * 0x1p31L);  // numbers as large as this are multiples of the place
    for (std::size_t i = 0; i < levels; ++i, near *= step) {
      const long double kept = (term + near) - near;
      at_[i] += kept;
      term -= kept;
    }
  }

  // NaN if a term was infinite or NaN.
  long double value() const {
    if (limit_ == 0) return 0;
    // How the sum is spread over the places depends on the order of the terms. So carries are taken up first.
    std::array<long double, levels> at = at_;
    long double place = lowest();
    for (std::size_t i = levels - 1; i > 0; --i) {
      place /= step;
      const long double carry = std::floor(at[i] / place) * place;
      at[i] -= carry;
      at[i - 1] += carry;
    }
    long double sum = 0;
    for (std::size_t i = levels; i > 0; --i) sum += at[i - 1];
    return sum;
  }

  // Each term was rounded by at most half of this; 0 for a sum of zeros.
  long double lowest() const {
    long double place = limit_;
    for (std::size_t i = 0; i < levels; ++i) place *= step;
    return place;
  }

 private:
  static constexpr int bits = 32;
  static constexpr long double step = 0x1p-32L;

  // Makes room for a term that is too large for the places so far.
  void reach(long double term) {
    if (term == 0) return;
    if (!std::isfinite(term)) {
      limit_ = std::numeric_limits<long double>::infinity();
      at_.fill(std::numeric_limits<long double>::quiet_NaN());
      return;
    }
    const int exponent = std::ilogb(term), top = exponent >= 0 ? exponent / bits : -((bits - 1 - exponent) / bits);
    const long double limit = std::ldexp(1.0L, bits * (top + 1));
    for (; limit_ < limit && limit_ > 0; limit_ /= step) {
      for (std::size_t i = levels - 1; i > 0; --i) at_[i] = at_[i - 1];
      at_[0] = 0;
    }
    limit_ = limit;
  }

  std::array<long double, levels> at_{};
  long double limit_ = 0;  // a power of 2^32 above all terms; 0: the sum is empty
};

}  // namespace tessera
