// The arrays of a tile file: one list for the code that writes tile files, writes the master file, and reads both.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"

namespace tessera::store {

// The elements of a VTK XML file that hold arrays, in the file's order.
enum class Section : std::uint8_t { points, point_data, cells, cell_data };
enum class ArrayOf : std::uint8_t { points, cells, corners };
// Plain: zlib streams of stored blocks, for data that hardly gets smaller. Deflated: for data that is nearly constant.
enum class Packing : std::uint8_t { plain, deflated };

struct ArrayInfo {
  Section section;
  std::string name;
  AttributeType type;
  ArrayOf rows;           // what has one row each
  std::uint64_t columns;  // numbers in a row
  Packing packing;
};

// Returns all arrays in the file's order. With `final` there is an array that says which cells of a region surely
// belong to the whole triangulation. `cell_schema` has the columns of the cells, which are the last arrays. With
// `images` there is an array that says how many periods each vertex lies away, by axis.
std::vector<ArrayInfo> tile_arrays(int dimension, bool final, bool neighbors, const std::vector<Attribute>& schema,
                                   const std::vector<Attribute>& cell_schema = {}, bool images = false);
inline constexpr const char* images_array = "period_offset";
inline constexpr std::size_t first_attribute = 4;  // index of the first attribute of the schema in that list
// The indices of these two arrays in the list. Without neighbors, neighbors_of() returns the list's size.
std::size_t connectivity_of(const std::vector<ArrayInfo>& arrays);
std::size_t neighbors_of(const std::vector<ArrayInfo>& arrays);

constexpr std::uint8_t vtk_cell_type(int dimension) { return dimension == 2 ? 5 : 10; }  // triangle, tetrahedron

// The schema with names that XML and VTK can store: '/', control characters and bytes that are not UTF-8 become '_'.
// The names "id", "owner", "vtkGhostType" and "period_offset" are taken, and get a trailing '_'. Error usage when two
// names collide or one is empty.
Result<std::vector<Attribute>> stored_schema(const std::vector<Attribute>& schema);
// The same for columns of cells, where "vtkGhostType", "tile", "final" and "neighbors" are taken.
Result<std::vector<Attribute>> stored_cell_schema(const std::vector<Attribute>& schema);

}  // namespace tessera::store
