#include "src/input/las/decimal_axis.h"

#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "src/input/bytes/number.h"

namespace tessera {
namespace {

using boost::multiprecision::cpp_int;
__extension__ using Int128 = __int128;
__extension__ using Uint128 = unsigned __int128;

struct Decimal {
  std::int64_t digits = 0;  // at most 17 digits
  int exponent = 0;         // value = digits * 10^exponent
};

// The shortest decimal that rounds to `value`.
Decimal shortest(double value) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific).ptr;
  Decimal decimal;
  int decimals = 0;
  bool after_point = false;
  const char* at = text;
  for (; at != end && *at != 'e'; ++at) {
    if (*at == '.') after_point = true;
    if (*at < '0' || *at > '9') continue;
    decimal.digits = decimal.digits * 10 + (*at - '0');
    decimals += after_point;
  }
  if (at != end) {
    at += at[1] == '+' ? 2 : 1;  // from_chars() does not accept '+'
    std::from_chars(at, end, decimal.exponent);
  }
  decimal.exponent -= decimals;
  if (text[0] == '-') decimal.digits = -decimal.digits;
  if (decimal.digits == 0) decimal.exponent = 0;
  return decimal;
}

cpp_int power_of_ten(int exponent) { return boost::multiprecision::pow(cpp_int(10), static_cast<unsigned>(exponent)); }

Int128 to_int128(const cpp_int& value) {
  const cpp_int magnitude = abs(value);
  const auto high = static_cast<std::uint64_t>(magnitude >> 64);
  const auto low = static_cast<std::uint64_t>(magnitude & UINT64_MAX);
  const auto bits = static_cast<Int128>(Uint128{high} << 64 | low);
  return value < 0 ? -bits : bits;
}

int leading_zeros(Uint128 value) {
  const auto high = static_cast<std::uint64_t>(value >> 64);
  return high != 0 ? std::countl_zero(high) : 64 + std::countl_zero(static_cast<std::uint64_t>(value));
}

// floor(a * b / 2^128).
Uint128 multiply_high(Uint128 a, Uint128 b) {
  constexpr Uint128 mask = UINT64_MAX;
  const Uint128 a0 = a & mask, a1 = a >> 64, b0 = b & mask, b1 = b >> 64;
  const Uint128 low = a0 * b0, mid1 = a1 * b0, mid2 = a0 * b1;
  const Uint128 carry = ((low >> 64) + (mid1 & mask) + (mid2 & mask)) >> 64;
  return a1 * b1 + (mid1 >> 64) + (mid2 >> 64) + carry;
}

// Division by D = 10^m with a reciprocal of 128 bits. A result is correctly rounded to double, or missing.
class Reciprocal {
 public:
  explicit Reciprocal(int m) {
    const cpp_int divisor = power_of_ten(m);
    divisor_bits_ = static_cast<int>(msb(divisor)) + 1;
    // L = divisor_bits_: 2^(L-1) <= D < 2^L, so R = floor((2^(127+L) - 1) / D) has exactly 128 bits.
    const cpp_int reciprocal = ((cpp_int(1) << (127 + divisor_bits_)) - 1) / divisor;
    reciprocal_ = Uint128{static_cast<std::uint64_t>(reciprocal >> 64)} << 64 |
                  static_cast<std::uint64_t>(reciprocal & UINT64_MAX);
  }

  // Returns magnitude / D rounded to nearest. Nothing if 128 bits do not show which way to round. REQUIRES: magnitude
  // != 0.
  std::optional<double> divide(Uint128 magnitude) const {
    const int shift = leading_zeros(magnitude);
    const Uint128 top = multiply_high(magnitude << shift, reciprocal_);
    // The quotient is t * 2^(1 - L - shift) with top <= t < top + 2. R is at most 1 less than 2^(127+L) / D. The factor
    // below 2^128 makes this an error below 1 after the shift, and multiply_high() cuts off less than 1.
    const int extra = 128 - 53 - leading_zeros(top);
    const Uint128 rest = top & ((Uint128{1} << extra) - 1);
    const Uint128 half = Uint128{1} << (extra - 1);
    if (rest == half || rest == half - 1) return std::nullopt;
    const auto mantissa = static_cast<std::uint64_t>(top >> extra) + (rest > half ? 1 : 0);
    // This is exact: a power of two between 2^-1022 and 2^1023 (see `divides`), and a product that is a normal double.
    const auto exponent = static_cast<std::uint64_t>(1023 + extra + 1 - divisor_bits_ - shift);
    return static_cast<double>(mantissa) * std::bit_cast<double>(exponent << 52);
  }

  // 10^290 has 964 bits. So exponents above are at least 1023 + 74 + 1 - 964 - 127 = 7, and quotients at least 10^-290.
  static bool divides(int m) { return m <= 290; }

 private:
  Uint128 reciprocal_ = 0;
  int divisor_bits_ = 0;
};

}  // namespace

struct DecimalAxis::Wide {
  cpp_int scale, offset;
  int m = 0;
  bool fits = false;  // N is below 2^127 for every 32-bit X, and the reciprocal can divide by 10^m
  Int128 scale128 = 0, offset128 = 0;
  std::optional<Reciprocal> reciprocal;
};

DecimalAxis::DecimalAxis(double scale, double offset) {
  const Decimal s = shortest(scale), o = shortest(offset);
  auto wide = std::make_shared<Wide>();
  const int exponent = std::min({s.exponent, o.exponent, 0});
  wide->m = -exponent;
  wide->scale = s.digits * power_of_ten(s.exponent - exponent);
  wide->offset = o.digits * power_of_ten(o.exponent - exponent);

  const cpp_int largest = (abs(wide->scale) << 31) + abs(wide->offset);
  wide->fits = largest < (cpp_int(1) << 127) && Reciprocal::divides(wide->m);
  if (wide->fits) {
    wide->scale128 = to_int128(wide->scale);
    wide->offset128 = to_int128(wide->offset);
    wide->reciprocal.emplace(wide->m);
  }

  const cpp_int exact = cpp_int(1) << 53;
  if (wide->m <= 22 && abs(wide->offset) <= exact && abs(wide->scale) <= exact && wide->scale != 0) {
    const cpp_int limit = (exact - abs(wide->offset)) / abs(wide->scale);
    fast_max_ = limit > INT32_MAX ? std::int64_t{1} << 31 : static_cast<std::int64_t>(limit);
    scale_ = static_cast<double>(static_cast<std::int64_t>(wide->scale));
    offset_ = static_cast<double>(static_cast<std::int64_t>(wide->offset));
    power_ = static_cast<double>(static_cast<std::int64_t>(power_of_ten(std::min(wide->m, 18))));
    for (int i = 18; i < wide->m; ++i) power_ *= 10;  // exact up to 10^22
  }
  wide_ = std::move(wide);
}

double DecimalAxis::slowly(std::int32_t integer) const {
  if (wide_->fits) {
    const Int128 n = integer * wide_->scale128 + wide_->offset128;
    if (n == 0) return 0;
    const auto quotient = wide_->reciprocal->divide(n < 0 ? -static_cast<Uint128>(n) : static_cast<Uint128>(n));
    if (quotient) return n < 0 ? -*quotient : *quotient;
  }
  // For ties, and for offsets and scales so far apart that N has more than 127 bits. Takes about 1 us.
  const cpp_int n = integer * wide_->scale + wide_->offset;
  return parse_number(n.str() + "e-" + std::to_string(wide_->m)).value_or(0);
}

}  // namespace tessera
