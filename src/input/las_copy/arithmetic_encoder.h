// The encoder of LAZ's adaptive arithmetic coder. It shares its models with the decoder.
// Source: A. Said, Introduction to Arithmetic Coding (HP Labs 2004); rapidlasso, LAZ Specification 1.4.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "src/input/laz/arithmetic_decoder.h"

namespace tessera::laz {

// One stream. Each function encodes what the decoder's function of the same name returns, and counts in the same model.
class ArithmeticEncoder {
 public:
  // REQUIRES: symbol < model.size().
  template <std::uint32_t capacity>
  void symbol(SymbolModel<capacity>& model, std::uint32_t symbol) {
    const std::uint32_t unit = length_ >> 15, low = model.share(symbol) * unit;
    const std::uint32_t high = symbol + 1 == model.size() ? length_ : model.share(symbol + 1) * unit;
    narrow(low, high - low);
    model.count(symbol);
  }

  void bit(BitModel& model, bool bit) {
    const std::uint32_t zero = model.zero_share() * (length_ >> 13);
    if (bit) {
      narrow(zero, length_ - zero);
    } else {
      narrow(0, zero);
    }
    model.count(bit);
  }

  // The lowest `count` bits of `value`. REQUIRES: 1 <= count <= 32; value has no other bits.
  void bits(std::uint32_t value, std::uint32_t count) {
    if (count > 19) {
      bits(value & 0xFFFF, 16);
      value >>= 16;
      count -= 16;
    }
    length_ >>= count;
    narrow(value * length_, length_);
  }

  // Returns the bytes: four, and one for each time that the decoder renormalises. So a decoder ends at the last byte.
  // The last two or three bytes are zero, which any number in the interval permits, as in the files of other writers.
  // REQUIRES: nothing is encoded afterwards.
  std::vector<std::byte> finish() {
    const bool long_interval = length_ > 2u << 24;
    narrow(long_interval ? 1u << 24 : 1u << 23, 1u << 24);
    base_ &= long_interval ? 0xFF000000u : 0xFFFF0000u;
    for (int i = 0; i < 4; ++i) shift_out();
    return std::move(out_);
  }

 private:
  // Goes on with the part of the interval that begins at `offset` and has this length.
  void narrow(std::uint32_t offset, std::uint32_t length) {
    const std::uint32_t before = base_;
    base_ += offset;
    length_ = length;
    if (base_ < before) carry();
    for (; length_ < 1u << 24; length_ <<= 8) shift_out();
  }

  // Adds one to the bytes that have left `base_`.
  void carry() {
    for (auto at = out_.rbegin(); at != out_.rend(); ++at) {
      *at = static_cast<std::byte>(std::to_integer<unsigned>(*at) + 1);
      if (*at != std::byte{0}) return;
    }
  }

  void shift_out() {
    out_.push_back(static_cast<std::byte>(base_ >> 24));
    base_ <<= 8;
  }

  std::uint32_t base_ = 0, length_ = 0xFFFFFFFFu;
  std::vector<std::byte> out_;
};

}  // namespace tessera::laz
