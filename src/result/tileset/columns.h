// Attributes of vertices by which viewers colour.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/attribute_value.h"

namespace tessera::tileset {

// The place of an attribute in the rows of a result; size 0: there is no such attribute.
struct Column {
  std::size_t offset = 0, size = 0;
  AttributeType type = AttributeType::f64;
  double at(const std::byte* row) const { return size == 0 ? 0 : as_double(type, row + offset); }
};

inline Column find_column(const std::vector<Attribute>& schema, const std::string& name) {
  Column column;
  for (const auto& attribute : schema) {
    if (attribute.name == name) return {column.offset, size_of(attribute.type), attribute.type};
    column.offset += size_of(attribute.type);
  }
  return {};
}

// Rounds to the nearest value of type T.
template <class T>
T clamped(double value) {
  if (!(value > 0)) return 0;
  return static_cast<T>(std::lround(std::min(value, static_cast<double>(std::numeric_limits<T>::max()))));
}

}  // namespace tessera::tileset
