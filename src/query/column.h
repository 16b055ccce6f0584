// Where in a vertex's attributes a value is.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "src/base/attribute.h"
#include "src/base/attribute_value.h"
#include "src/base/result.h"
#include "src/store/tile_store.h"

namespace tessera::query {

struct Column {
  std::size_t offset = 0;
  AttributeType type = AttributeType::f64;
  // Of a vertex with this row of attributes.
  double value(const std::byte* row) const { return as_double(type, row + offset); }
};

// Error usage when vertices of the result in `out` have no attribute of this name. "z": the heights of a 2D result.
Result<Column> find_column(const std::filesystem::path& out, const Manifest& manifest, const std::string& name);

}  // namespace tessera::query
