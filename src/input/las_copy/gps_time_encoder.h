// GPS times; see GpsTimes, which says what the codes mean. Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "src/input/las_copy/integer_encoder.h"
#include "src/input/laz/prediction.h"

namespace tessera::laz {

// The other half of GpsTimes<may_repeat>. The format leaves the choice of codes to the encoder. This encoder stays in
// its sequence while the difference has 32 bits. Then it changes to a sequence to which that applies, or begins one.
template <bool may_repeat>
class GpsTimeEncoder {
 public:
  explicit GpsTimeEncoder(std::int64_t first = 0) { sequences_[0].time = first; }

  void next(ArithmeticEncoder& encoder, std::int64_t time) {
    if (may_repeat && time == sequences_[current_].time) return put(encoder, repeat);
    if (fits(0, time)) return continue_sequence(encoder, time);
    for (std::uint32_t turn = 1; turn < sequences_.size(); ++turn) {
      if (!fits(turn, time)) continue;
      put(encoder, begin + turn);
      current_ = (current_ + turn) & 3;
      if (may_repeat && time == sequences_[current_].time) return put(encoder, repeat);
      return continue_sequence(encoder, time);
    }
    begin_sequence(encoder, time);
  }

 private:
  static constexpr std::int32_t multiple_max = 500, multiple_min = -10;
  static constexpr std::uint32_t multiple_codes = multiple_max - multiple_min + 1;
  // Codes after those of differences; begin + turn: a change of sequence.
  static constexpr std::uint32_t repeat = 0, begin = may_repeat;

  struct Sequence {
    std::int64_t time = 0;
    std::int32_t difference = 0;  // the usual difference; 0: none yet
    std::uint32_t extremes = 0;   // successive differences that were no small multiple of the usual one
  };

  static std::int64_t minus(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
  }
  bool fits(std::uint32_t turn, std::int64_t time) const {
    const std::int64_t moved = minus(time, sequences_[(current_ + turn) & 3].time);
    return moved == static_cast<std::int32_t>(moved);
  }

  // A code that is no difference. Without a usual difference the code of a difference stands behind `repeat`.
  void put(ArithmeticEncoder& encoder, std::uint32_t code) {
    if (sequences_[current_].difference != 0) return encoder.symbol(multiples_, multiple_codes + code);
    encoder.symbol(first_differences_, code < begin ? code : code + 1);
  }

  // REQUIRES: fits(0, time).
  void continue_sequence(ArithmeticEncoder& encoder, std::int64_t time) {
    auto& s = sequences_[current_];
    const auto moved = static_cast<std::int32_t>(minus(time, s.time));
    s.time = time;
    if (s.difference != 0) return put_multiple(encoder, s, moved);
    encoder.symbol(first_differences_, may_repeat);
    corrections_.next(encoder, 0, moved, 0);
    s.difference = moved;
    s.extremes = 0;
  }

  void put_multiple(ArithmeticEncoder& encoder, Sequence& s, std::int32_t moved) {
    const auto multiple = static_cast<std::int32_t>(
        std::clamp<double>(std::round(static_cast<double>(moved) / s.difference), multiple_min, multiple_max));
    encoder.symbol(multiples_, static_cast<std::uint32_t>(multiple >= 0 ? multiple : multiple_max - multiple));
    if (multiple == 1) {
      s.extremes = 0;
      return corrections_.next(encoder, s.difference, moved, 1);
    }
    const std::uint32_t context = multiple == 0              ? 7
                                  : multiple == multiple_max ? 4
                                  : multiple == multiple_min ? 6
                                  : multiple < 0             ? 5
                                  : multiple < 10            ? 2
                                                             : 3;
    corrections_.next(encoder, wrapping_multiply(multiple, s.difference), moved, context);
    if ((multiple == 0 || multiple == multiple_max || multiple == multiple_min) && ++s.extremes > 3) {
      s.difference = moved;
      s.extremes = 0;
    }
  }

  void begin_sequence(ArithmeticEncoder& encoder, std::int64_t time) {
    put(encoder, begin);
    corrections_.next(encoder, static_cast<std::int32_t>(sequences_[current_].time >> 32),
                      static_cast<std::int32_t>(time >> 32), 8);
    encoder.bits(static_cast<std::uint32_t>(time), 32);
    current_ = newest_ = (newest_ + 1) & 3;
    sequences_[current_] = {.time = time};
  }

  std::array<Sequence, 4> sequences_;
  std::uint32_t current_ = 0, newest_ = 0;
  SymbolModel<5 + may_repeat> first_differences_;
  SymbolModel<multiple_codes + 4 + may_repeat> multiples_;
  IntegerEncoder<32, 9> corrections_;
};

}  // namespace tessera::laz
