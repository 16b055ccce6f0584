// Reads an attribute of one point from a row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "src/base/attribute.h"

namespace tessera {

// Calls `visit` with the value at `from`, in its own type. Returns what `visit` returns.
template <class Visit>
auto visit_value(AttributeType type, const std::byte* from, Visit&& visit) {
  const auto as = [&](auto value) {
    std::memcpy(&value, from, sizeof value);
    return visit(value);
  };
  switch (type) {
    case AttributeType::u8:
      return as(std::uint8_t{});
    case AttributeType::i8:
      return as(std::int8_t{});
    case AttributeType::u16:
      return as(std::uint16_t{});
    case AttributeType::i16:
      return as(std::int16_t{});
    case AttributeType::u32:
      return as(std::uint32_t{});
    case AttributeType::i32:
      return as(std::int32_t{});
    case AttributeType::u64:
      return as(std::uint64_t{});
    case AttributeType::i64:
      return as(std::int64_t{});
    case AttributeType::f32:
      return as(float{});
    case AttributeType::f64:
      break;
  }
  return as(double{});
}

inline double as_double(AttributeType type, const std::byte* from) {
  return visit_value(type, from, [](auto value) { return static_cast<double>(value); });
}

// Where the value of an attribute stands in a row.
struct AttributeColumn {
  std::size_t offset = 0;
  AttributeType type = AttributeType::f64;
  double value(const std::byte* row) const { return as_double(type, row + offset); }
};

// Finds the attribute `name` in rows of this schema. Returns nothing when the schema lacks the attribute.
inline std::optional<AttributeColumn> column_of(const std::vector<Attribute>& schema, std::string_view name) {
  std::size_t offset = 0;
  for (const Attribute& attribute : schema) {
    if (attribute.name == name) return AttributeColumn{offset, attribute.type};
    offset += size_of(attribute.type);
  }
  return std::nullopt;
}

}  // namespace tessera
