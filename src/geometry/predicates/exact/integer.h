// Signed integers of a fixed number of 64-bit limbs, for determinants whose size is known beforehand. They allocate no
// memory. A product has as many limbs as both factors together, so it never overflows. The caller must make sure that
// sums fit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tessera::exact {

__extension__ typedef unsigned __int128 Wide;

template <std::size_t N>
struct Integer {
  std::array<std::uint64_t, N> limb{};  // two's complement, least significant first

  bool negative() const { return limb[N - 1] >> 63; }
  int sign() const {
    if (negative()) return -1;
    std::uint64_t any = 0;
    for (const std::uint64_t l : limb) any |= l;
    return any != 0;
  }

  friend Integer operator+(const Integer& a, const Integer& b) {
    Integer sum;
    Wide carry = 0;
    for (std::size_t i = 0; i < N; ++i) {
      carry += Wide{a.limb[i]} + b.limb[i];
      sum.limb[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    return sum;
  }
  friend Integer operator-(const Integer& a, const Integer& b) {
    Integer difference = a;
    difference.subtract(b.limb.data(), 0);
    return difference;
  }

  // Subtracts other * 2^(64 shift), modulo 2^(64 N); `other` has N - shift limbs or more.
  void subtract(const std::uint64_t* other, std::size_t shift) {
    Wide borrow = 0;
    for (std::size_t i = shift; i < N; ++i) {
      const Wide t = Wide{limb[i]} - other[i - shift] - borrow;
      limb[i] = static_cast<std::uint64_t>(t);
      borrow = (t >> 64) & 1;
    }
  }
};

template <std::size_t M, std::size_t N>
Integer<M + N> operator*(const Integer<M>& a, const Integer<N>& b) {
  Integer<M + N> product;
  for (std::size_t i = 0; i < M; ++i) {
    Wide carry = 0;
    for (std::size_t j = 0; j < N; ++j) {
      carry += Wide{a.limb[i]} * b.limb[j] + product.limb[i + j];
      product.limb[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    product.limb[i + N] = static_cast<std::uint64_t>(carry);
  }
  // Read as unsigned, a negative factor was too large by 2^(64 * its number of limbs). These lines correct that.
  if (a.negative()) product.subtract(b.limb.data(), M);
  if (b.negative()) product.subtract(a.limb.data(), N);
  return product;
}

}  // namespace tessera::exact
