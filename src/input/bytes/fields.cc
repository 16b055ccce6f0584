#include "src/input/bytes/fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

#include "src/base/printable.h"
#include "src/base/utf8.h"

namespace tessera {
namespace {

// The types in the order of AttributeType.
using Types = std::tuple<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                         std::uint64_t, std::int64_t, float, double>;
constexpr std::size_t type_count = std::tuple_size_v<Types>;

template <class To, class From>
To convert(From value) {
  using Limits = std::numeric_limits<To>;
  if constexpr (std::is_same_v<To, From>) {
    return value;
  } else if constexpr (std::floating_point<To> && std::floating_point<From>) {
    // A double beyond the range of float. Without IEC 559 the conversion would be undefined behaviour.
    if constexpr (sizeof(To) < sizeof(From)) {
      if (std::isfinite(value) && std::abs(value) > Limits::max())
        return std::copysign(Limits::infinity(), static_cast<To>(value > 0 ? 1 : -1));
    }
    return static_cast<To>(value);
  } else if constexpr (std::floating_point<To>) {
    return static_cast<To>(value);
  } else if constexpr (std::floating_point<From>) {
    if (std::isnan(value)) return 0;
    // max() may round up to 2^k in From, which is already out of range. So the comparison is >= and not >.
    if (value >= static_cast<From>(Limits::max())) return Limits::max();
    if (value <= static_cast<From>(Limits::min())) return Limits::min();
    return static_cast<To>(value);
  } else {
    if (std::cmp_greater(value, Limits::max())) return Limits::max();
    if (std::cmp_less(value, Limits::min())) return Limits::min();
    return static_cast<To>(value);
  }
}

template <class From, bool swapped>
From load_as(const std::byte* at) {
  if constexpr (!swapped || sizeof(From) == 1) {
    return load<From>(at);
  } else {
    std::array<std::byte, sizeof(From)> bytes;
    std::reverse_copy(at, at + sizeof(From), bytes.begin());
    return std::bit_cast<From>(bytes);
  }
}

template <class From, bool swapped, class To>
void copy_column(const std::byte* from, std::size_t from_stride, std::byte* to, std::size_t to_stride, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i, from += from_stride, to += to_stride) {
    const To value = convert<To>(load_as<From, swapped>(from));
    std::memcpy(to, &value, sizeof value);
  }
}

template <bool swapped, std::size_t... pair>
constexpr auto make_table(std::index_sequence<pair...>) {
  return std::array<ColumnCopy, sizeof...(pair)>{copy_column<std::tuple_element_t<pair / type_count, Types>, swapped,
                                                             std::tuple_element_t<pair % type_count, Types>>...};
}

constexpr auto as_is = make_table<false>(std::make_index_sequence<type_count * type_count>());
constexpr auto swapped = make_table<true>(std::make_index_sequence<type_count * type_count>());

std::string with_underscores(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    clean += is_printable(text, length) && text[0] != '/' ? text.substr(0, length) : "_";
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return clean;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

ColumnCopy column_copy(AttributeType from, bool byte_swapped, AttributeType to) {
  const std::size_t pair = static_cast<std::size_t>(from) * type_count + static_cast<std::size_t>(to);
  return byte_swapped ? swapped[pair] : as_is[pair];
}

std::string AttributeNames::make(std::string_view raw) {
  std::string_view short_enough = raw.substr(0, 64);
  // A UTF-8 sequence must not be cut in two.
  while (short_enough.size() < raw.size() && !short_enough.empty() &&
         (static_cast<unsigned char>(raw[short_enough.size()]) & 0xC0u) == 0x80u)
    short_enough.remove_suffix(1);
  const std::string clean = with_underscores(short_enough);
  std::string name(trimmed(clean));
  if (name.empty() || name == "." || name == "..") name += "_";
  std::string unique = name;
  for (int& i = next_.try_emplace(name, 2).first->second; !taken_.insert(unique).second; ++i)
    unique = name + "_" + std::to_string(i);
  return unique;
}

std::vector<std::size_t> row_offsets(const std::vector<Attribute>& schema) {
  std::vector<std::size_t> offsets;
  std::size_t offset = 0;
  for (const auto& a : schema) {
    offsets.push_back(offset);
    offset += size_of(a.type);
  }
  return offsets;
}

}  // namespace tessera
