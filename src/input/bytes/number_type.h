// Types of numbers as formats name them: a kind and a number of bytes.
#pragma once

#include <cstdint>
#include <optional>

#include "src/base/attribute.h"

namespace tessera {

enum class NumberKind : std::uint8_t { floating, with_sign, without_sign };

// Nothing if there is no such number.
inline std::optional<AttributeType> number_type(NumberKind kind, std::uint64_t bytes) {
  using enum AttributeType;
  if (kind == NumberKind::floating)
    return bytes == 4 ? std::optional(f32) : bytes == 8 ? std::optional(f64) : std::nullopt;
  const bool sign = kind == NumberKind::with_sign;
  switch (bytes) {
    case 1:
      return sign ? i8 : u8;
    case 2:
      return sign ? i16 : u16;
    case 4:
      return sign ? i32 : u32;
    case 8:
      return sign ? i64 : u64;
    default:
      return std::nullopt;
  }
}

}  // namespace tessera
