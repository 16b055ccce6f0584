// Colours: first which bytes have changed, then the changed bytes as differences. Green and blue are predicted from
// red.
// Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "src/input/laz/arithmetic_decoder.h"

namespace tessera::laz {

struct Rgb {
  std::uint16_t red = 0, green = 0, blue = 0;
};

inline std::uint32_t clamp_byte(int value) { return static_cast<std::uint32_t>(std::clamp(value, 0, 255)); }

// The models of RGB12 version 2 and RGB14 versions 3 and 4.
class RgbModels {
 public:
  Rgb next(ArithmeticDecoder& decoder, const Rgb& last) {
    const std::uint32_t changed = decoder.symbol(changed_);
    const auto byte = [&](unsigned bit, std::uint32_t predicted, std::uint32_t same) {
      return (changed >> bit & 1) != 0 ? (decoder.symbol(differences_[bit]) + predicted) & 0xFF : same;
    };
    const std::uint32_t red = byte(0, low(last.red), low(last.red));
    const std::uint32_t red_high = byte(1, high(last.red), high(last.red));
    const Rgb grey{joined(red, red_high), joined(red, red_high), joined(red, red_high)};
    if ((changed >> 6 & 1) == 0) return grey;
    // Green is predicted from red, and blue from the mean of both. The low bytes come first.
    const auto pair = [&](unsigned bit, int red_moved, std::uint32_t last_green, std::uint32_t last_blue) {
      const std::uint32_t green = byte(bit, clamp_byte(red_moved + static_cast<int>(last_green)), last_green);
      const int moved = (red_moved + static_cast<int>(green) - static_cast<int>(last_green)) / 2;
      return std::pair(green, byte(bit + 2, clamp_byte(moved + static_cast<int>(last_blue)), last_blue));
    };
    const auto [green, blue] =
        pair(2, static_cast<int>(red) - static_cast<int>(low(last.red)), low(last.green), low(last.blue));
    const auto [green_high, blue_high] =
        pair(3, static_cast<int>(red_high) - static_cast<int>(high(last.red)), high(last.green), high(last.blue));
    return {grey.red, joined(green, green_high), joined(blue, blue_high)};
  }

 private:
  static std::uint32_t low(std::uint16_t v) { return v & 0xFFu; }
  static std::uint32_t high(std::uint16_t v) { return v >> 8u; }
  static std::uint16_t joined(std::uint32_t low, std::uint32_t high) {
    return static_cast<std::uint16_t>(high << 8 | low);
  }

  SymbolModel<128> changed_;
  std::array<SymbolModel<256>, 6> differences_;  // low and high byte of red, green, blue
};

// The models of the near infrared of RGBNIR14.
class NirModels {
 public:
  std::uint16_t next(ArithmeticDecoder& decoder, std::uint16_t last) {
    const std::uint32_t changed = decoder.symbol(changed_);
    std::uint32_t low = last & 0xFFu, high = last >> 8u;
    if ((changed & 1) != 0) low = (low + decoder.symbol(differences_[0])) & 0xFF;
    if ((changed & 2) != 0) high = (high + decoder.symbol(differences_[1])) & 0xFF;
    return static_cast<std::uint16_t>(high << 8 | low);
  }

 private:
  SymbolModel<4> changed_;
  std::array<SymbolModel<256>, 2> differences_;
};

}  // namespace tessera::laz
