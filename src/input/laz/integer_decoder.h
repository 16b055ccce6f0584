// Integers as corrections of a prediction: how many bits the correction has, then the upper ones of those as a symbol
// and the rest as they are. Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "src/input/laz/arithmetic_decoder.h"

namespace tessera::laz {

// Numbers of `bits` bits (modulo 2^bits), with `contexts` ways to be predicted. Models come to be when they are first
// used: most never are.
template <std::uint32_t bits, std::uint32_t contexts = 1>
class IntegerDecoder {
 public:
  // The number that `prediction` was meant to be. REQUIRES: context < contexts.
  std::int32_t next(ArithmeticDecoder& decoder, std::int32_t prediction, std::uint32_t context = 0) {
    auto& model = lengths_[context];
    if (!model) model = std::make_unique<SymbolModel<bits + 1>>();
    length_ = decoder.symbol(*model);
    const std::uint32_t sum = static_cast<std::uint32_t>(prediction) + correction(decoder);
    if constexpr (bits == 32) {
      return static_cast<std::int32_t>(sum);
    } else {
      return static_cast<std::int32_t>(sum & ((1u << bits) - 1));
    }
  }
  // Bits of the last correction: the larger, the worse the prediction. At most `bits`.
  std::uint32_t length() const { return length_; }

 private:
  static constexpr std::uint32_t upper_bits = 8;

  // Of length k > 0: -2^k + 1 .. -2^(k-1) or 2^(k-1) + 1 .. 2^k.
  std::uint32_t correction(ArithmeticDecoder& decoder) {
    if (length_ == 0) return decoder.bit(zero_or_one_);
    if (length_ == 32) return 1u << 31;
    auto& model = upper_[length_];
    if (!model) model = std::make_unique<SymbolModel<1u << upper_bits>>(1u << std::min(length_, upper_bits));
    std::uint32_t c = decoder.symbol(*model);
    if (length_ > upper_bits) {
      const std::uint32_t low = length_ - upper_bits;
      c = c << low | decoder.bits(low);
    }
    return c >= 1u << (length_ - 1) ? c + 1 : c - ((1u << length_) - 1);
  }

  std::uint32_t length_ = 0;
  BitModel zero_or_one_;
  std::array<std::unique_ptr<SymbolModel<bits + 1>>, contexts> lengths_;
  std::array<std::unique_ptr<SymbolModel<1u << upper_bits>>, bits + 1> upper_;
};

}  // namespace tessera::laz
