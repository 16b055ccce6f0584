// Integers as corrections of a prediction; see IntegerDecoder. Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>

#include "src/input/las_copy/arithmetic_encoder.h"

namespace tessera::laz {

// The difference, which wraps around.
inline std::int32_t moved(std::int32_t from, std::int32_t to) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) - static_cast<std::uint32_t>(from));
}

// The other half of IntegerDecoder<bits, contexts>.
template <std::uint32_t bits, std::uint32_t contexts = 1>
class IntegerEncoder {
 public:
  // Encodes `value`, of which the lowest `bits` bits count. REQUIRES: context < contexts.
  void next(ArithmeticEncoder& encoder, std::int32_t prediction, std::int32_t value, std::uint32_t context = 0) {
    const std::int32_t correction =
        shortest(static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(prediction));
    // A correction of length k > 0 is in -2^k + 1 .. -2^(k-1) or in 2^(k-1) + 1 .. 2^k.
    const auto size =
        correction <= 0 ? 0u - static_cast<std::uint32_t>(correction) : static_cast<std::uint32_t>(correction) - 1;
    length_ = static_cast<std::uint32_t>(std::bit_width(size));
    auto& model = lengths_[context];
    if (!model) model = std::make_unique<SymbolModel<bits + 1>>();
    encoder.symbol(*model, length_);
    if (length_ == 0) {
      encoder.bit(zero_or_one_, correction == 1);
    } else if (length_ < 32) {
      put(encoder, static_cast<std::uint32_t>(correction < 0 ? correction + ((std::int64_t{1} << length_) - 1)
                                                             : std::int64_t{correction} - 1));
    }
  }
  // The number of bits of the last correction, at most `bits`.
  std::uint32_t length() const { return length_; }

 private:
  static constexpr std::uint32_t upper_bits = 8;

  // The correction of the smallest size that is equal modulo 2^bits.
  static std::int32_t shortest(std::uint32_t correction) {
    return static_cast<std::int32_t>(correction << (32 - bits)) >> (32 - bits);
  }

  // Encodes the number that stands for a correction of length_ bits.
  void put(ArithmeticEncoder& encoder, std::uint32_t c) {
    auto& model = upper_[length_];
    if (!model) model = std::make_unique<SymbolModel<1u << upper_bits>>(1u << std::min(length_, upper_bits));
    const std::uint32_t low = length_ > upper_bits ? length_ - upper_bits : 0;
    encoder.symbol(*model, c >> low);
    if (low > 0) encoder.bits(c & ((1u << low) - 1), low);
  }

  std::uint32_t length_ = 0;
  BitModel zero_or_one_;
  std::array<std::unique_ptr<SymbolModel<bits + 1>>, contexts> lengths_;
  std::array<std::unique_ptr<SymbolModel<1u << upper_bits>>, bits + 1> upper_;
};

}  // namespace tessera::laz
