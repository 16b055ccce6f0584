#include "src/result/store/column_block.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace tessera::store {

namespace {

// The bits to flip so that the bits of a type's numbers have the order of the values: the sign bit of integers.
constexpr std::uint64_t flipped(AttributeType type) {
  switch (type) {
    case AttributeType::i8:
    case AttributeType::i16:
    case AttributeType::i32:
    case AttributeType::i64:
      return std::uint64_t{1} << (8 * size_of(type) - 1);
    default:
      return 0;
  }
}

constexpr std::uint32_t ordered_float(std::uint32_t bits) { return bits ^ (bits >> 31u == 0 ? 1u << 31u : ~0u); }
constexpr std::uint32_t unordered_float(std::uint32_t number) {
  return number ^ (number >> 31u == 0 ? ~0u : 1u << 31u);
}

template <class Word>
void load(const Column& column, std::uint64_t flip, std::uint64_t* numbers) {
  const std::byte* at = column.first;
  for (std::size_t i = 0; i < column.rows; ++i, at += column.stride) {
    Word word;
    std::memcpy(&word, at, sizeof word);
    numbers[i] = word ^ flip;
  }
}

template <class Word>
void store(const std::uint64_t* numbers, std::uint64_t flip, const ColumnBuffer& column) {
  std::byte* at = column.first;
  for (std::size_t i = 0; i < column.rows; ++i, at += column.stride) {
    const auto word = static_cast<Word>(numbers[i] ^ flip);
    std::memcpy(at, &word, sizeof word);
  }
}

void load(const Column& column, std::uint64_t* numbers) {
  const std::uint64_t flip = flipped(column.type);
  switch (size_of(column.type)) {
    case 1:
      return load<std::uint8_t>(column, flip, numbers);
    case 2:
      return load<std::uint16_t>(column, flip, numbers);
    case 4:
      return load<std::uint32_t>(column, flip, numbers);
    default:
      return load<std::uint64_t>(column, flip, numbers);
  }
}

void store(const std::uint64_t* numbers, const ColumnBuffer& column) {
  const std::uint64_t flip = flipped(column.type);
  switch (size_of(column.type)) {
    case 1:
      return store<std::uint8_t>(numbers, flip, column);
    case 2:
      return store<std::uint16_t>(numbers, flip, column);
    case 4:
      return store<std::uint32_t>(numbers, flip, column);
    default:
      return store<std::uint64_t>(numbers, flip, column);
  }
}

std::uint64_t bits_of(std::span<const std::uint64_t> numbers) {
  std::uint64_t bits = 0;
  for (const std::uint64_t number : numbers) bits |= number;
  return bits;
}

// Maps signed integers to unsigned ones in the same order.
constexpr std::uint64_t sign = std::uint64_t{1} << 63u;

// Computes for each number its multiple, and what must be added to the prediction, folded. Returns how many of these
// corrections are larger than rounding explains.
constexpr std::uint64_t rounding = 16;
template <bool multiplies>
std::size_t predict(const GridScale& scale, std::span<const std::uint64_t> bits, std::uint64_t* multiples,
                    std::uint64_t* misses) {
  std::size_t far = 0;
  for (const std::uint64_t value : bits) {
    const std::int64_t k = scale.multiple(std::bit_cast<double>(value));
    const auto whole = static_cast<double>(k);
    const auto predicted = std::bit_cast<std::uint64_t>(multiplies ? whole * scale.step() : whole / scale.scale());
    const std::uint64_t miss = folded(ordered(value) - ordered(predicted));
    *multiples++ = static_cast<std::uint64_t>(k) ^ sign;
    *misses++ = miss;
    far += miss > rounding ? 1 : 0;
  }
  return far;
}

template <bool multiplies>
void restore(const GridScale& scale, std::span<std::uint64_t> numbers, const std::uint64_t* misses) {
  for (std::uint64_t& number : numbers) {
    const auto k = static_cast<double>(static_cast<std::int64_t>(number ^ sign));
    const auto predicted = std::bit_cast<std::uint64_t>(multiplies ? k * scale.step() : k / scale.scale());
    number = misses == nullptr ? predicted : unordered(ordered(predicted) + unfolded(*misses++));
  }
}

}  // namespace

// The least scale that fits a sample of the values. Values that the scale misses are added to the sample, and the
// search goes on. A few values may be missed: those that mark a missing value.
std::optional<GridScale> ColumnBlocks::find_scale() {
  constexpr std::size_t sampled = 64, learnt_at_most = 16;
  const std::size_t rows = numbers_.size();
  multiples_.resize(rows);
  misses_.resize(rows);
  sample_.clear();
  for (std::size_t i = 0; i < rows; i += (rows + sampled - 1) / sampled)
    sample_.push_back(std::bit_cast<double>(numbers_[i]));
  GridFinder finder;
  for (std::size_t learnt = 0; learnt <= learnt_at_most; ++learnt) {
    const auto scale = finder.next(sample_);
    if (!scale) return {};
    const auto predict_all = scale->multiplies() ? predict<true> : predict<false>;
    if (predict_all(*scale, numbers_, multiples_.data(), misses_.data()) <= rows / 32) return scale;
    std::size_t i = 0;
    while (i < rows && (misses_[i] <= rounding || !GridFinder::counts(std::bit_cast<double>(numbers_[i])))) ++i;
    if (i == rows) return scale;
    sample_.push_back(std::bit_cast<double>(numbers_[i]));
  }
  return {};
}

void ColumnBlocks::append_doubles(BigVector<std::byte>& to) {
  const auto scale = find_scale();
  to.push_back(static_cast<std::byte>(scale ? scale->code() : 0));
  if (scale) {
    integers_.append(multiples_, to);
    integers_.append(misses_, to);
    return;
  }
  for (std::uint64_t& number : numbers_) number = ordered(number);
  integers_.append(numbers_, to);
}

void ColumnBlocks::append(const Column& column, BigVector<std::byte>& to) {
  numbers_.resize(column.rows);
  load(column, numbers_.data());
  if (column.type == AttributeType::f64) return append_doubles(to);
  if (column.type == AttributeType::f32)
    for (std::uint64_t& number : numbers_) number = ordered_float(static_cast<std::uint32_t>(number));
  integers_.append(numbers_, to);
}

const char* ColumnBlocks::take_doubles(std::span<const std::byte>& block, std::span<std::uint64_t> numbers) {
  if (block.empty()) return "ends too early";
  const auto code = static_cast<std::uint8_t>(block[0]);
  block = block.subspan(1);
  const auto scale = GridScale::of_code(code);
  if (code != 0 && !scale) return "is coded in an unknown way";
  if (const char* wrong = integers_.take(block, numbers)) return wrong;
  if (!scale) {
    for (std::uint64_t& number : numbers) number = unordered(number);
    return nullptr;
  }
  // Integers that a double cannot hold are refused.
  std::uint64_t wide = 0;
  constexpr std::uint64_t reach = std::uint64_t{1} << 53u;
  for (const std::uint64_t number : numbers) wide |= ((number ^ sign) + reach) & ~(2 * reach - 1);
  if (wide != 0) return "has a multiple that is too large";
  const bool all_hit = IntegerBlocks::says_zeros(block);
  misses_.resize(numbers.size());
  if (const char* wrong = integers_.take(block, misses_)) return wrong;
  const std::uint64_t* misses = all_hit ? nullptr : misses_.data();
  scale->multiplies() ? restore<true>(*scale, numbers, misses) : restore<false>(*scale, numbers, misses);
  return nullptr;
}

const char* ColumnBlocks::take(std::span<const std::byte> block, const ColumnBuffer& column) {
  numbers_.resize(column.rows);
  const std::span numbers(numbers_);
  if (const char* wrong =
          column.type == AttributeType::f64 ? take_doubles(block, numbers) : integers_.take(block, numbers))
    return wrong;
  if (!block.empty()) return "has bytes after its end";
  if (const std::size_t size = size_of(column.type); size < 8)
    if (bits_of(numbers) >> (8 * size) != 0) return "has a value too large for its type";
  if (column.type == AttributeType::f32)
    for (std::uint64_t& number : numbers) number = unordered_float(static_cast<std::uint32_t>(number));
  store(numbers.data(), column);
  return nullptr;
}

}  // namespace tessera::store
