// Numbers with twice the digits of a long double, 128 bits on x86: a number and what it is rounded by. They are some
// ten times as fast as a number of software with as many bits, and have the exponents of a long double.
// Sources: Dekker, A floating-point technique for extending the available precision, Numerische Mathematik 18 (1971);
// Joldes, Muller, Popescu, Tight and rigorous error bounds for basic building blocks of double-word arithmetic, ACM
// Transactions on Mathematical Software 44 (2017).
#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

namespace tessera {

class Twofold {
 public:
  Twofold() = default;
  template <class Other>
  requires std::is_arithmetic_v<Other> Twofold(Other number)
      : high_(number) {}  // NOLINT(google-explicit-constructor): as other numbers

  // Each operation is right to this share of its result, but for additions of numbers with different signs, which are
  // right to this share of the numbers.
  static constexpr long double epsilon() { return 32 * unit * unit; }

  Twofold operator-() const { return {-high_, -low_}; }
  friend Twofold operator+(const Twofold& a, const Twofold& b) {
    const Twofold high = sum(a.high_, b.high_), low = sum(a.low_, b.low_);
    const Twofold once = quick_sum(high.high_, high.low_ + low.high_);
    return quick_sum(once.high_, low.low_ + once.low_);
  }
  friend Twofold operator-(const Twofold& a, const Twofold& b) { return a + -b; }
  friend Twofold operator*(const Twofold& a, const Twofold& b) {
    const Twofold high = product(a.high_, b.high_);
    return quick_sum(high.high_, high.low_ + (a.high_ * b.low_ + a.low_ * b.high_));
  }
  friend Twofold operator/(const Twofold& a, const Twofold& b) {
    const long double first = a.high_ / b.high_;
    const Twofold rest = a - b * Twofold(first);
    return quick_sum(first, rest.high_ / b.high_);
  }
  Twofold& operator+=(const Twofold& other) { return *this = *this + other; }
  friend Twofold sqrt(const Twofold& a) {
    const long double first = std::sqrt(a.high_);
    if (first == 0) return {};
    const Twofold rest = a - product(first, first);
    return quick_sum(first, rest.high_ / (2 * first));
  }
  friend bool operator<(const Twofold& a, const Twofold& b) {
    return a.high_ < b.high_ || (a.high_ == b.high_ && a.low_ < b.low_);
  }
  friend bool operator>(const Twofold& a, const Twofold& b) { return b < a; }
  friend bool operator==(const Twofold& a, const Twofold& b) = default;
  friend long double rounded(const Twofold& number) { return number.high_; }

 private:
  static constexpr int digits = std::numeric_limits<long double>::digits;
  static constexpr long double unit = std::numeric_limits<long double>::epsilon() / 2;

  Twofold(long double high, long double low) : high_(high), low_(low) {}

  static Twofold sum(long double a, long double b) {
    const long double s = a + b, from_b = s - a;
    return {s, (a - (s - from_b)) + (b - from_b)};
  }
  // REQUIRES: |a| >= |b|, or a is 0.
  static Twofold quick_sum(long double a, long double b) {
    const long double s = a + b;
    return {s, b - (s - a)};
  }
  // The upper half of the digits. Source: Veltkamp, as told by Dekker.
  static long double upper(long double a) {
    constexpr long double factor = static_cast<long double>((1ULL << ((digits + 1) / 2)) + 1);
    const long double scaled = factor * a;
    return scaled - (scaled - a);
  }
  static Twofold product(long double a, long double b) {
    const long double p = a * b, au = upper(a), bu = upper(b), al = a - au, bl = b - bu;
    return {p, ((au * bu - p) + au * bl + al * bu) + al * bl};
  }

  long double high_ = 0, low_ = 0;
};

}  // namespace tessera
