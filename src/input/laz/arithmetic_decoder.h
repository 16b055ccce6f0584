// The decoder of LAZ's adaptive arithmetic coder.
// Source: A. Said, Introduction to Arithmetic Coding (HP Labs 2004) and its FastAC; rapidlasso, LAZ Specification 1.4.
// The decoder is safe on any bytes: a symbol is always below the size of its alphabet. Damage shows as a wrong end of
// the stream.
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

// The model of a bit: its probability is learnt.
class BitModel {
 public:
  std::uint32_t zero_share() const { return zero_share_; }  // in units of 2^-13
  void count(bool bit) {
    zeros_ += !bit;
    if (--until_update_ == 0) update();
  }

 private:
  void update();
  std::uint32_t zeros_ = 1, total_ = 2, zero_share_ = 1u << 12, cycle_ = 4, until_update_ = 4;
};

// The model of `size` symbols, at most `capacity`: their probabilities are learnt. share() is cumulative, in units of
// 2^-15, and increasing. The format does not say how to find a share. Here a table gives the start by the upper bits of
// the value, and 16 shares from there on are compared without a branch. That is nearly always enough.
template <std::uint32_t capacity>
class SymbolModel {
 public:
  explicit SymbolModel(std::uint32_t size = capacity) : size_(size), cycle_(size) {
    shares_.fill(UINT16_MAX);  // shares behind the last symbol exceed any value
    counts_.fill(1);
    update();
    cycle_ = until_update_ = (size_ + 6) >> 1;
  }

  std::uint32_t size() const { return size_; }
  std::uint32_t share(std::uint32_t symbol) const { return shares_[symbol]; }

  // Returns the last symbol whose share is at most `value`. REQUIRES: value < (table_size << table_shift).
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
  // Values may be a little above 2^15, because symbol() divides by a length that was rounded down.
  static constexpr std::uint32_t table_size = (1u << (15 - table_shift)) + 1;
  static constexpr bool has_table = capacity > step;

  // Returns how many of `step` increasing shares are at most `value`, which is below 2^16.
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

  // a comparison may begin at the last symbol and be repeated once
  std::array<std::uint16_t, capacity + 2 * step> shares_;
  std::array<std::uint16_t, capacity> counts_;
  std::array<std::uint16_t, has_table ? table_size : 0> table_;
  std::uint32_t size_, total_ = 0, cycle_, until_update_ = 0;
};

class ArithmeticDecoder {
 public:
  ArithmeticDecoder() = default;
  explicit ArithmeticDecoder(ByteFeed feed) : feed_(std::move(feed)) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | feed_.byte();
    // No coder makes this value. It would break value_ < length_, on which the bounds of all symbols depend.
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

  // Returns `count` equally likely bits. REQUIRES: 1 <= count <= 32.
  std::uint32_t bits(std::uint32_t count) {
    if (count > 19) {
      const std::uint32_t low = bits(16);
      return bits(count - 16) << 16 | low;
    }
    length_ >>= count;
    const std::uint32_t bits = value_ / length_;
    value_ -= bits * length_;
    renormalise();
    // The rounding of length_ permits more than 2^count values. No coder uses the others.
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
