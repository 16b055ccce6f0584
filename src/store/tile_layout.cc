#include "src/store/tile_layout.h"

#include <algorithm>
#include <set>

namespace tessera::store {

std::vector<ArrayInfo> tile_arrays(int dimension, bool neighbors, const std::vector<Attribute>& schema) {
  const auto corners = static_cast<std::uint64_t>(dimension + 1);
  std::vector<ArrayInfo> arrays{
      {"Points", AttributeType::f64, ArrayOf::points, 3},
      {"Connectivity", AttributeType::i32, ArrayOf::connectivity, 1},
      {"Offsets", AttributeType::i32, ArrayOf::cells_plus_one, 1},
      {"Types", AttributeType::u8, ArrayOf::cells, 1},
      {"PointData/id", AttributeType::u64, ArrayOf::points, 1},
      {"PointData/vtkGhostType", AttributeType::u8, ArrayOf::points, 1},
  };
  for (const auto& attribute : schema)
    arrays.push_back({"PointData/" + attribute.name, attribute.type, ArrayOf::points, 1});
  arrays.push_back({"CellData/vtkGhostType", AttributeType::u8, ArrayOf::cells, 1});
  if (neighbors) arrays.push_back({"CellData/neighbors", AttributeType::i32, ArrayOf::cells, corners});
  return arrays;
}

Result<std::vector<Attribute>> stored_schema(const std::vector<Attribute>& schema) {
  std::vector<Attribute> result = schema;
  std::set<std::string> names{"id", "vtkGhostType"};
  for (auto& attribute : result) {
    std::replace(attribute.name.begin(), attribute.name.end(), '/', '_');
    if (attribute.name == "id" || attribute.name == "vtkGhostType") attribute.name += '_';
    if (attribute.name.empty() || attribute.name == "." || attribute.name.find('\0') != std::string::npos)
      return error(Errc::usage, "an attribute whose name is empty cannot be stored");
    if (!names.insert(attribute.name).second)
      return error(Errc::usage, "two attributes would both be stored as '" + attribute.name + "'");
  }
  return result;
}

}  // namespace tessera::store
