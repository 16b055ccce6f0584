// Colours; see RgbModels and NirModels. Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <array>
#include <cstdint>

#include "src/input/las_copy/arithmetic_encoder.h"
#include "src/input/laz/colour.h"

namespace tessera::laz {

// The other half of RgbModels.
class RgbEncoder {
 public:
  void next(ArithmeticEncoder& encoder, const Rgb& last, const Rgb& value) {
    const Bytes before(last), now(value);
    std::uint32_t changed = 0;
    for (std::uint32_t bit = 0; bit < 6; ++bit) changed |= std::uint32_t{now.of[bit] != before.of[bit]} << bit;
    const bool grey = value.red == value.green && value.red == value.blue;
    if (!grey) changed |= 64;
    encoder.symbol(changed_, changed);
    const auto byte = [&](unsigned bit, std::uint32_t predicted) {
      if ((changed >> bit & 1) != 0) encoder.symbol(differences_[bit], (now.of[bit] - predicted) & 0xFF);
    };
    byte(0, before.of[0]);
    byte(1, before.of[1]);
    if (grey) return;
    // Green is predicted from red, and blue from the mean of both. The low bytes come first.
    for (unsigned half = 0; half < 2; ++half) {
      const auto moved_of = [&](unsigned bit) {
        return static_cast<int>(now.of[bit]) - static_cast<int>(before.of[bit]);
      };
      const int red_moved = moved_of(half);
      byte(2 + half, clamp_byte(red_moved + static_cast<int>(before.of[2 + half])));
      const int moved = (red_moved + moved_of(2 + half)) / 2;
      byte(4 + half, clamp_byte(moved + static_cast<int>(before.of[4 + half])));
    }
  }

 private:
  struct Bytes {
    explicit Bytes(const Rgb& v) {
      const std::array<std::uint32_t, 3> colours{v.red, v.green, v.blue};
      for (std::size_t i = 0; i < 6; ++i) of[i] = colours[i / 2] >> 8 * (i % 2) & 0xFF;
    }
    std::array<std::uint32_t, 6> of{};  // low and high byte of red, green, blue
  };

  SymbolModel<128> changed_;
  std::array<SymbolModel<256>, 6> differences_;
};

// The other half of NirModels.
class NirEncoder {
 public:
  void next(ArithmeticEncoder& encoder, std::uint16_t last, std::uint16_t value) {
    const bool low = ((last ^ value) & 0xFF) != 0, high = ((last ^ value) >> 8) != 0;
    encoder.symbol(changed_, std::uint32_t{low} | std::uint32_t{high} << 1);
    if (low) encoder.symbol(differences_[0], static_cast<std::uint32_t>(value - last) & 0xFF);
    if (high) encoder.symbol(differences_[1], static_cast<std::uint32_t>((value >> 8) - (last >> 8)) & 0xFF);
  }

 private:
  SymbolModel<4> changed_;
  std::array<SymbolModel<256>, 2> differences_;
};

}  // namespace tessera::laz
