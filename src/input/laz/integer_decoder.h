// Integers as corrections of a prediction. A symbol says how many bits the correction has. Its upper bits follow as a
// symbol, and the other bits as they are. Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "src/input/laz/arithmetic_decoder.h"

namespace tessera::laz {

// Numbers of `bits` bits (modulo 2^bits) that are predicted in one of `contexts` ways. Models are made when they are
// first used, because most are never used.
template <std::uint32_t bits, std::uint32_t contexts = 1>
class IntegerDecoder {
 public:
  // Returns the number that was predicted as `prediction`. REQUIRES: context < contexts.
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
  // The number of bits of the last correction, at most `bits`. It is larger for worse predictions.
  std::uint32_t length() const { return length_; }

 private:
  static constexpr std::uint32_t upper_bits = 8;

  // A correction of length k > 0 is in -2^k + 1 .. -2^(k-1) or in 2^(k-1) + 1 .. 2^k.
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
