// Sums whose bits do not depend on the order of their terms.
//
// A sum has digits of 24 bits, whose places are fixed powers of two. A term is cut into such digits, and each digit is
// added to its place as an integer, without carries. A sum keeps the five highest places that any of its terms has
// reached; lower digits are dropped. Whether a digit is kept depends only on the greatest term, not on the order: a
// digit that the final places include was never below the places before. So a term is cut off at most 2^-96 of the
// greatest term. Source: Demmel, Nguyen, Parallel reproducible summation, IEEE Transactions on Computers 64 (2015).
#pragma once

#include <array>
#include <cstdint>

#include "src/result/measure/scaled_double.h"

namespace tessera {

// An object whose bytes are all zero is an empty sum, so sums can be kept in files as they are. REQUIRES: at most 2^38
// terms.
class OrderFreeSum {
 public:
  void add(const ScaledDouble& term);
  void add(const OrderFreeSum& other);
  // Adds a term that is no number. The sum is none then, whatever else is added.
  void spoil() { state_ = State::spoiled; }
  bool spoiled() const { return state_ == State::spoiled; }
  // The sum, rounded once. REQUIRES: not spoiled.
  ScaledDouble value() const;

 private:
  static constexpr int places = 5, bits = 24;
  enum class State : std::int32_t { empty = 0, sum = 1, spoiled = 2 };
  void reach(std::int32_t top);  // keeps the places from `top` down, if `top` is higher than the highest so far

  std::array<std::int64_t, places> digits_{};  // of the places top_, top_ - 1, ...; place p is worth 2^(24 p)
  std::int32_t top_ = 0;
  State state_ = State::empty;
};

}  // namespace tessera
