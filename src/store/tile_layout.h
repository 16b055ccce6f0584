// What a tile file consists of: one table for those who write tile files, the master file, and read them back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"

namespace tessera::store {

enum class ArrayOf : std::uint8_t { points, cells, cells_plus_one, connectivity };

struct ArrayInfo {
  std::string name;  // below /VTKHDF
  AttributeType type;
  ArrayOf rows;           // what there is one row of
  std::uint64_t columns;  // 1: a one-dimensional dataset
};

// All arrays in the order in which they are created.
std::vector<ArrayInfo> tile_arrays(int dimension, bool neighbors, const std::vector<Attribute>& schema);

constexpr std::uint8_t vtk_cell_type(int dimension) { return dimension == 2 ? 5 : 10; }  // triangle, tetrahedron

// The schema with names under which HDF5 and VTK can keep them: '/' becomes '_', and "id" and "vtkGhostType", which
// are taken, get a trailing '_'. Error usage when two names collide or one is empty.
Result<std::vector<Attribute>> stored_schema(const std::vector<Attribute>& schema);

}  // namespace tessera::store
