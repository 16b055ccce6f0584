// GPS times: doubles that are compressed as the integers of their bits, in up to four sequences (flight lines).
// Source: rapidlasso, LAZ Specification 1.4.
#pragma once

#include <array>
#include <cstdint>

#include "src/input/laz/integer_decoder.h"
#include "src/input/laz/prediction.h"

namespace tessera::laz {

// The times of GPSTIME11 version 2, where `may_repeat` adds a code for "the same time again", and of the GPS time layer
// of POINT14 version 3, which leaves out such points.
template <bool may_repeat>
class GpsTimes {
 public:
  explicit GpsTimes(std::int64_t first = 0) { sequences_[0].time = first; }

  std::int64_t next(ArithmeticDecoder& decoder) {
    while (true) {
      auto& s = sequences_[current_];
      // The codes: first those of the model itself, then the same time again (if may_repeat), then the first time of a
      // new sequence, then a change to one of the three other sequences, whose code follows.
      std::uint32_t code;
      if (s.difference == 0) {
        code = decoder.symbol(first_differences_);
        if (may_repeat && code == 0) return s.time;
        code -= may_repeat;
        if (code == 0) {
          s.difference = corrections_.next(decoder, 0, 0);
          s.extremes = 0;
          return s.time = wrapping_add(s.time, std::int64_t{s.difference});
        }
        code -= 1;
      } else {
        code = decoder.symbol(multiples_);
        if (code < multiple_codes) return s.time = wrapping_add(s.time, std::int64_t{difference(s, code, decoder)});
        code -= multiple_codes;
        if (may_repeat && code == 0) return s.time;
        code -= may_repeat;
      }
      if (code == 0) return new_sequence(decoder);
      current_ = (current_ + code) & 3;
    }
  }

 private:
  static constexpr std::int32_t multiple_max = 500, multiple_min = -10;
  static constexpr std::uint32_t multiple_codes = multiple_max - multiple_min + 1;

  struct Sequence {
    std::int64_t time = 0;
    std::int32_t difference = 0;  // the usual difference; 0: none yet
    std::uint32_t extremes = 0;   // successive differences that were no small multiple of the usual one
  };

  std::int32_t difference(Sequence& s, std::uint32_t code, ArithmeticDecoder& decoder) {
    const auto multiple =
        code <= multiple_max ? static_cast<std::int32_t>(code) : multiple_max - static_cast<std::int32_t>(code);
    if (multiple == 1) {
      s.extremes = 0;
      return corrections_.next(decoder, s.difference, 1);
    }
    const std::uint32_t context = multiple == 0              ? 7
                                  : multiple == multiple_max ? 4
                                  : multiple == multiple_min ? 6
                                  : multiple < 0             ? 5
                                  : multiple < 10            ? 2
                                                             : 3;
    const std::int32_t found = corrections_.next(decoder, wrapping_multiply(multiple, s.difference), context);
    if ((multiple == 0 || multiple == multiple_max || multiple == multiple_min) && ++s.extremes > 3) {
      s.difference = found;
      s.extremes = 0;
    }
    return found;
  }

  std::int64_t new_sequence(ArithmeticDecoder& decoder) {
    const auto upper = static_cast<std::int32_t>(sequences_[current_].time >> 32);
    newest_ = (newest_ + 1) & 3;
    const auto predicted = static_cast<std::uint32_t>(corrections_.next(decoder, upper, 8));
    const std::uint64_t bits = std::uint64_t{predicted} << 32 | decoder.bits(32);
    current_ = newest_;
    return (sequences_[current_] = {.time = static_cast<std::int64_t>(bits)}).time;
  }

  std::array<Sequence, 4> sequences_;
  std::uint32_t current_ = 0, newest_ = 0;
  SymbolModel<5 + may_repeat> first_differences_;
  SymbolModel<multiple_codes + 4 + may_repeat> multiples_;
  IntegerDecoder<32, 9> corrections_;
};

}  // namespace tessera::laz
