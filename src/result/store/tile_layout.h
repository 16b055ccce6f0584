// What a tile file consists of: one table for those who write tile files, the master file, and read them back.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"

namespace tessera::store {

// The elements of a VTK XML file that hold arrays, in the order in which they stand.
enum class Section : std::uint8_t { points, point_data, cells, cell_data };
enum class ArrayOf : std::uint8_t { points, cells, corners };
// Plain: zlib streams of stored blocks, for what hardly gets smaller. Deflated: for what is nearly constant.
enum class Packing : std::uint8_t { plain, deflated };

struct ArrayInfo {
  Section section;
  std::string name;
  AttributeType type;
  ArrayOf rows;           // what there is one row of
  std::uint64_t columns;  // numbers in a row
  Packing packing;
};

// All arrays in the order in which they stand in the file.
// `final`: of a part of a triangulation, whether each cell is one of the whole for sure.
// `cell_schema`: columns of the cells, the last arrays of all.
std::vector<ArrayInfo> tile_arrays(int dimension, bool final, bool neighbors, const std::vector<Attribute>& schema,
                                   const std::vector<Attribute>& cell_schema = {});
inline constexpr std::size_t first_attribute = 4;  // where those of the schema begin in that list
// Where these two are in it; its end without neighbors.
std::size_t connectivity_of(const std::vector<ArrayInfo>& arrays);
std::size_t neighbors_of(const std::vector<ArrayInfo>& arrays);

constexpr std::uint8_t vtk_cell_type(int dimension) { return dimension == 2 ? 5 : 10; }  // triangle, tetrahedron

// The schema with names under which XML and VTK can keep them: '/', control characters and what is not UTF-8 become
// '_', and "id", "owner" and "vtkGhostType", which are taken, get a trailing '_'. Error usage when two names collide or
// one is empty.
Result<std::vector<Attribute>> stored_schema(const std::vector<Attribute>& schema);
// The same of columns of cells, where "vtkGhostType", "tile", "final" and "neighbors" are taken.
Result<std::vector<Attribute>> stored_cell_schema(const std::vector<Attribute>& schema);

}  // namespace tessera::store
