// The place of a value in a vertex's attributes.
#pragma once

#include <filesystem>
#include <string>

#include "src/base/attribute_value.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::query {

using Column = AttributeColumn;

// Error usage when the vertices of the result in `out` have no attribute of this name. "z" has the heights of a 2D
// result.
Result<Column> find_column(const std::filesystem::path& out, const Manifest& manifest, const std::string& name);

}  // namespace tessera::query
