// The other half of the arithmetic coder, for files that no writer makes any more (items of version 1). It shares its
// models with the decoder: what these do is proven by the real files, here it is the items that are tested.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>

#include "src/input/laz/arithmetic_decoder.h"
#include "tests/input/io_testing.h"

namespace tessera::testing_io {

class ArithmeticEncoder {
 public:
  template <std::uint32_t capacity>
  void symbol(laz::SymbolModel<capacity>& model, std::uint32_t symbol) {
    const std::uint32_t unit = length_ >> 15, low = model.share(symbol) * unit;
    const std::uint32_t high = symbol + 1 == model.size() ? length_ : model.share(symbol + 1) * unit;
    narrow(low, high - low);
    model.count(symbol);
  }
  void bit(laz::BitModel& model, bool bit) {
    const std::uint32_t zero = model.zero_share() * (length_ >> 13);
    bit ? narrow(zero, length_ - zero) : narrow(0, zero);
    model.count(bit);
  }
  void bits(std::uint32_t value, std::uint32_t count) {
    if (count > 19) {
      bits(value & 0xFFFF, 16);
      value >>= 16;
      count -= 16;
    }
    length_ >>= count;
    narrow(value * length_, length_);
  }
  // The bytes, as many as the decoder reads: four, and one for each time it renormalises.
  Bytes finish() {
    narrow(length_ / 2, 1u << 24);
    for (int i = 0; i < 4; ++i, base_ <<= 8) out_.push_back(static_cast<std::byte>(base_ >> 24));
    return std::move(out_);
  }

 private:
  void narrow(std::uint32_t offset, std::uint32_t length) {
    const std::uint32_t before = base_;
    base_ += offset;
    length_ = length;
    if (base_ < before)
      for (auto at = out_.rbegin(); at != out_.rend() && ++reinterpret_cast<std::uint8_t&>(*at) == 0; ++at) {
      }
    for (; length_ < 1u << 24; base_ <<= 8, length_ <<= 8) out_.push_back(static_cast<std::byte>(base_ >> 24));
  }

  std::uint32_t base_ = 0, length_ = 0xFFFFFFFFu;
  Bytes out_;
};

template <std::uint32_t bits, std::uint32_t contexts = 1>
class IntegerEncoder {
 public:
  void next(ArithmeticEncoder& encoder, std::int32_t prediction, std::int32_t value, std::uint32_t context = 0) {
    auto correction =
        static_cast<std::int32_t>(static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(prediction));
    if constexpr (bits < 32) correction = (correction << (32 - bits)) >> (32 - bits);
    const auto size =
        static_cast<std::uint32_t>(correction <= 0 ? -static_cast<std::int64_t>(correction) : correction - 1);
    length = static_cast<std::uint32_t>(std::bit_width(size));
    encoder.symbol(lengths_[context], length);
    if (length == 0) return encoder.bit(zero_or_one_, correction == 1);
    if (length == 32) return;
    const auto c = static_cast<std::uint32_t>(
        correction < 0 ? correction + static_cast<std::int32_t>((1ll << length) - 1) : correction - 1);
    auto& model = upper_[length];
    if (!model) model = std::make_unique<laz::SymbolModel<256>>(1u << std::min(length, 8u));
    const std::uint32_t low = length > 8 ? length - 8 : 0;
    encoder.symbol(*model, c >> low);
    if (low > 0) encoder.bits(c & ((1u << low) - 1), low);
  }
  std::uint32_t length = 0;

 private:
  laz::BitModel zero_or_one_;
  std::array<laz::SymbolModel<bits + 1>, contexts> lengths_;
  std::array<std::unique_ptr<laz::SymbolModel<256>>, bits + 1> upper_;
};

}  // namespace tessera::testing_io
