// The adaptive arithmetic coder of LAZ, the decoding half.
// Source: A. Said, Introduction to Arithmetic Coding (HP Labs 2004) and its FastAC; rapidlasso, LAZ Specification 1.4.
// Safe on any bytes: symbols are always below the size of their alphabet. Damage shows as a wrong end of the stream.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "src/input/laz/byte_feed.h"

namespace tessera::laz {

// A bit whose probability is learnt.
class BitModel {
 public:
  std::uint32_t zero_share() const { return zero_share_; }  // of 2^13
  void count(bool bit) {
    zeros_ += !bit;
    if (--until_update_ == 0) update();
  }

 private:
  void update();
  std::uint32_t zeros_ = 1, total_ = 2, zero_share_ = 1u << 12, cycle_ = 4, until_update_ = 4;
};

// `size` symbols, at most `capacity`, whose probabilities are learnt. share() is cumulative, of 2^15, increasing. How a
// share is found does not matter to the format: here a table says where to begin for the upper bits of the value, and
// 16 shares from there on are compared without a branch, which nearly always is enough.
template <std::uint32_t capacity>
class SymbolModel {
 public:
  explicit SymbolModel(std::uint32_t size = capacity) : size_(size), cycle_(size) {
    shares_.fill(UINT16_MAX);  // behind the last symbol: larger than any value
    counts_.fill(1);
    update();
    cycle_ = until_update_ = (size_ + 6) >> 1;
  }

  std::uint32_t size() const { return size_; }
  std::uint32_t share(std::uint32_t symbol) const { return shares_[symbol]; }

  // The last symbol whose share is at most `value`. REQUIRES: value < (table_size << table_shift).
  std::uint32_t find(std::uint32_t value) const {
    std::uint32_t begin = 0;
    if constexpr (has_table) begin = table_[value >> table_shift];
    while (true) {
      const std::uint32_t n = at_most(&shares_[begin], value);
      if (n < step) return begin + n - 1;
      begin += step;
    }
  }

  void count(std::uint32_t symbol) {
    ++counts_[symbol];
    if (--until_update_ == 0) update();
  }

 private:
  static constexpr std::uint32_t step = 16, table_shift = 9;
  // Values reach a little beyond 2^15, because a length is rounded down when it is divided by that: see symbol().
  static constexpr std::uint32_t table_size = (1u << (15 - table_shift)) + 1;
  static constexpr bool has_table = capacity > step;

  // How many of `step` increasing shares are at most `value`, which is below 2^16.
  static std::uint32_t at_most(const std::uint16_t* shares, std::uint32_t value) {
#ifdef __SSE2__
    const auto* at = reinterpret_cast<const __m128i*>(shares);
    const __m128i values = _mm_set1_epi16(static_cast<std::int16_t>(value)), zero = _mm_setzero_si128();
    const __m128i low = _mm_cmpeq_epi16(_mm_subs_epu16(_mm_loadu_si128(at), values), zero);
    const __m128i high = _mm_cmpeq_epi16(_mm_subs_epu16(_mm_loadu_si128(at + 1), values), zero);
    return static_cast<std::uint32_t>(
        std::countr_one(static_cast<unsigned>(_mm_movemask_epi8(_mm_packs_epi16(low, high)))));
#else
    std::uint32_t n = 0;
    for (std::uint32_t i = 0; i < step; ++i) n += shares[i] <= value;
    return n;
#endif
  }

  void update() {
    if ((total_ += cycle_) > 1u << 15) {
      total_ = 0;
      for (std::uint32_t i = 0; i < size_; ++i)
        total_ += counts_[i] = static_cast<std::uint16_t>((counts_[i] + 1u) >> 1);
    }
    const std::uint32_t scale = 0x80000000u / total_;
    std::uint32_t sum = 0;
    for (std::uint32_t i = 0; i < size_; ++i) {
      shares_[i] = static_cast<std::uint16_t>((scale * sum) >> 16);
      sum += counts_[i];
    }
    if constexpr (has_table) {
      std::uint32_t symbol = 0;
      for (std::uint32_t i = 0; i < table_size; ++i) {
        while (symbol + 1 < size_ && shares_[symbol + 1] <= i << table_shift) ++symbol;
        table_[i] = static_cast<std::uint16_t>(symbol);
      }
    }
    cycle_ = until_update_ = std::min((5 * cycle_) >> 2, (size_ + 6) << 3);
  }

  std::array<std::uint16_t, capacity + 2 * step> shares_;  // a comparison may begin at the last and go on once
  std::array<std::uint16_t, capacity> counts_;
  std::array<std::uint16_t, has_table ? table_size : 0> table_;
  std::uint32_t size_, total_ = 0, cycle_, until_update_ = 0;
};

class ArithmeticDecoder {
 public:
  ArithmeticDecoder() = default;
  explicit ArithmeticDecoder(ByteFeed feed) : feed_(std::move(feed)) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | feed_.byte();
    // No coder makes this; it would break value_ < length_, on which the bounds of all symbols rest.
    if (value_ == length_) --value_;
  }

  bool bit(BitModel& model) {
    const std::uint32_t zero = model.zero_share() * (length_ >> 13);
    const bool one = value_ >= zero;
    value_ -= one ? zero : 0;
    length_ = one ? length_ - zero : zero;
    renormalise();
    model.count(one);
    return one;
  }

  template <std::uint32_t capacity>
  std::uint32_t symbol(SymbolModel<capacity>& model) {
    const std::uint32_t unit = length_ >> 15;
    const std::uint32_t symbol = model.find(value_ / unit);
    const std::uint32_t low = model.share(symbol) * unit;
    const std::uint32_t high = symbol + 1 == model.size() ? length_ : model.share(symbol + 1) * unit;
    value_ -= low;
    length_ = high - low;
    renormalise();
    model.count(symbol);
    return symbol;
  }

  // `count` equally likely bits, 1 to 32.
  std::uint32_t bits(std::uint32_t count) {
    if (count > 19) {
      const std::uint32_t low = bits(16);
      return bits(count - 16) << 16 | low;
    }
    length_ >>= count;
    const std::uint32_t bits = value_ / length_;
    value_ -= bits * length_;
    renormalise();
    // Rounding of length_ leaves room for more than 2^count values, which no coder uses.
    return bits & ((1u << count) - 1);
  }
  std::uint64_t bits64() {
    const std::uint64_t low = bits(32);
    return std::uint64_t{bits(32)} << 32 | low;
  }

  const ByteFeed& feed() const { return feed_; }

 private:
  void renormalise() {
    while (length_ < 1u << 24) {
      value_ = value_ << 8 | feed_.byte();
      length_ <<= 8;
    }
  }

  std::uint32_t value_ = 0, length_ = 0xFFFFFFFFu;
  ByteFeed feed_;
};

inline void BitModel::update() {
  if ((total_ += cycle_) > 1u << 13) {
    total_ = (total_ + 1) >> 1;
    zeros_ = (zeros_ + 1) >> 1;
    if (zeros_ == total_) ++total_;
  }
  zero_share_ = (zeros_ * (0x80000000u / total_)) >> 18;
  cycle_ = std::min((5 * cycle_) >> 2, 64u);
  until_update_ = cycle_;
}

}  // namespace tessera::laz
