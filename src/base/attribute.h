// Attributes: data of points that the result takes over from the input, such as intensity, classification or colours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

enum class AttributeType : std::uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

constexpr std::size_t size_of(AttributeType type) {
  switch (type) {
    case AttributeType::u8:
    case AttributeType::i8:
      return 1;
    case AttributeType::u16:
    case AttributeType::i16:
      return 2;
    case AttributeType::u32:
    case AttributeType::i32:
    case AttributeType::f32:
      return 4;
    case AttributeType::u64:
    case AttributeType::i64:
    case AttributeType::f64:
      return 8;
  }
  return 0;
}

struct Attribute {
  std::string name;  // as VTK shows it: "intensity", "classification", "return_number", "gps_time", "red", ...
  AttributeType type = AttributeType::f64;
  std::string unit = {};  // of the values, as the input states it, for people; "" when unknown
  // Units are compared by nobody: texts for the same unit differ.
  friend bool operator==(const Attribute& a, const Attribute& b) { return a.name == b.name && a.type == b.type; }
};

// The bytes of a row. A row has the attributes of one point, packed in the order of the schema without padding.
inline std::size_t row_bytes(const std::vector<Attribute>& schema) {
  std::size_t bytes = 0;
  for (const auto& a : schema) bytes += size_of(a.type);
  return bytes;
}

}  // namespace tessera
