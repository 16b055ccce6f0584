// What is put on a grid: a density, or a field that is linear in each cell, or the divergence, curl or
// shear of one.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/base/result.h"
#include "src/result/density/linear.h"
#include "src/result/measure/scaled_double.h"
#include "src/result/store/tile_store.h"

namespace tessera::density {

// The shear is the symmetric part of the gradient of a vector, without its trace: (d_i v_j + d_j v_i) / 2, less 1/d of
// the divergence where i = j. Its last diagonal component is minus the sum of the others, and is left out. Source:
// Cautun, van de Weygaert, The DTFE public software, arXiv:1105.0370 (2011).
enum class GridKind : std::uint8_t { density, field, divergence, curl, shear };

// Of a vector in this dimension, whose components are d attributes.
constexpr bool is_of_vector(GridKind kind) {
  return kind == GridKind::divergence || kind == GridKind::curl || kind == GridKind::shear;
}
// How many numbers a voxel has: of the curl 1 in 2D and 3 in 3D; of the shear 2, xx and xy, and 5, xx, xy, xz, yy, yz.
constexpr std::size_t components_of(GridKind kind, int dimension) {
  if (kind == GridKind::curl && dimension == 3) return 3;
  if (kind == GridKind::shear) return dimension == 2 ? 2 : 5;
  return 1;
}
// What is added to the name of the quantity: "_x" or "_xy", or "" if there is one component.
std::string component_suffix(GridKind kind, int dimension, std::size_t component);

// A linear function in a cell: its values at the vertices, times 2^exponent.
struct CellFunction {
  bool known = true;  // false when a value is not finite
  std::array<double, 4> values{};
  int exponent = 0;

  // The integral over a part of the cell, divided by the part's volume unit.
  ScaledDouble over(const std::array<double, 4>& weights) const {
    double sum = 0;
    for (std::size_t k = 0; k < values.size(); ++k) sum += weights[k] * values[k];
    return ScaledDouble::of(sum, exponent);
  }
};

// The functions of a cell, one for each component.
using CellFunctions = std::array<CellFunction, 5>;

class Quantity {
 public:
  // `names`: nothing for a density, one attribute for a field, d attributes for the components of a vector. Error usage
  // for another number of names, and for an attribute that the vertices do not have.
  static Result<Quantity> find(const std::filesystem::path& out, const Manifest& manifest, GridKind kind,
                               const std::vector<std::string>& names);

  GridKind kind() const { return kind_; }
  std::size_t components() const { return components_of(kind_, dimension_); }
  bool needs_rows() const { return kind_ != GridKind::density; }

  // The functions in a cell. `vertices` are the cell's, in the order of their ids; `corners`
  // their coordinates; `volume` is d! times the signed volume of `corners`. `densities` are those of the tile's
  // vertices if the kind is density, else empty.
  CellFunctions in_cell(const StoredTile& tile, std::span<const std::size_t> vertices, std::span<const Point> corners,
                        const ScaledDouble& volume, std::span<const ScaledDouble> densities) const;

 private:
  using Slopes = std::array<std::array<ScaledDouble, 3>, 3>;  // [i][j]: of component i along axis j
  CellFunctions derivative(const StoredTile& tile, std::span<const std::size_t> vertices,
                           std::span<const Point> corners, const ScaledDouble& volume) const;
  CellFunctions of_slopes(const Slopes& by) const;

  GridKind kind_ = GridKind::density;
  int dimension_ = 3;
  std::size_t row_bytes_ = 0;
  std::vector<AttributeColumn> columns_;
};

}  // namespace tessera::density
