#include "src/result/measure/order_free_sum.h"

#include <cmath>
#include <cstdlib>

namespace tessera {
namespace {

__extension__ using Int128 = __int128;
__extension__ using Unsigned128 = unsigned __int128;

}  // namespace

void OrderFreeSum::reach(std::int32_t top) {
  if (state_ == State::empty) {
    state_ = State::sum;
    top_ = top;
    return;
  }
  if (top <= top_) return;
  const std::int32_t up = top - top_;
  for (int i = places - 1; i >= 0; --i)
    digits_[static_cast<std::size_t>(i)] = i >= up ? digits_[static_cast<std::size_t>(i - up)] : 0;
  top_ = top;
}

void OrderFreeSum::add(const ScaledDouble& term) {
  if (term.fraction == 0 || state_ == State::spoiled) return;
  constexpr int mantissa = 53, parts = 4;
  const auto whole = static_cast<std::int64_t>(std::ldexp(term.fraction, mantissa));
  const int last_bit = term.exponent - mantissa;
  const int low = last_bit >= 0 ? last_bit / bits : -((bits - 1 - last_bit) / bits);  // rounded down
  const auto magnitude = static_cast<Unsigned128>(std::llabs(whole)) << static_cast<unsigned>(last_bit - bits * low);
  std::array<std::int64_t, parts> part{};
  int highest = 0;
  for (int i = 0; i < parts; ++i) {
    const auto digit = static_cast<std::int64_t>((magnitude >> static_cast<unsigned>(bits * i)) & ((1U << bits) - 1));
    if (digit != 0) highest = i;
    part[static_cast<std::size_t>(i)] = whole < 0 ? -digit : digit;
  }
  reach(low + highest);
  for (int i = 0; i <= highest; ++i) {
    const int place = top_ - (low + i);
    if (place < places) digits_[static_cast<std::size_t>(place)] += part[static_cast<std::size_t>(i)];
  }
}

void OrderFreeSum::add(const OrderFreeSum& other) {
  if (other.state_ == State::empty || state_ == State::spoiled) return;
  if (other.state_ == State::spoiled) return spoil();
  reach(other.top_);
  for (int i = 0; i < places; ++i) {
    const int place = top_ - other.top_ + i;
    if (place < places) digits_[static_cast<std::size_t>(place)] += other.digits_[static_cast<std::size_t>(i)];
  }
}

ScaledDouble OrderFreeSum::value() const {
  std::array<std::int64_t, places> digits = digits_;
  for (std::size_t i = places - 1; i > 0; --i) {
    const std::int64_t carry = digits[i] >> bits;  // rounded down, so that the digit is not negative
    digits[i] -= carry * (std::int64_t{1} << bits);
    digits[i - 1] += carry;
  }
  // As many digits as 128 bits hold; what is below only says on which side of a tie the sum is.
  const std::int64_t first = std::llabs(digits[0]);
  const std::size_t used = first < (1 << 6) ? 5 : first < (1 << 30) ? 4 : 3;
  Int128 sum = 0;
  for (std::size_t i = 0; i < used; ++i) sum = sum * (1 << bits) + digits[i];
  for (std::size_t i = used; i < places; ++i)
    if (digits[i] != 0) sum |= 1;
  return ScaledDouble::of(static_cast<double>(sum), bits * (top_ - static_cast<int>(used) + 1));
}

}  // namespace tessera
