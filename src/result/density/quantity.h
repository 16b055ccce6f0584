// What is put on a grid: a density, or a field that is linear in each cell, or the divergence or curl of one.
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

enum class GridKind : std::uint8_t { density, field, divergence, curl };

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

class Quantity {
 public:
  // `names`: nothing for a density, one attribute for a field, d attributes for the components of a vector. Error usage
  // for another number of names, and for an attribute that the vertices do not have.
  static Result<Quantity> find(const std::filesystem::path& out, const Manifest& manifest, GridKind kind,
                               const std::vector<std::string>& names);

  GridKind kind() const { return kind_; }
  std::size_t components() const { return kind_ == GridKind::curl && dimension_ == 3 ? 3 : 1; }
  bool needs_rows() const { return kind_ != GridKind::density; }

  // The functions in a cell, one for each component. `vertices` are the cell's, in the order of their ids; `corners`
  // their coordinates; `volume` is d! times the signed volume of `corners`. `densities` are those of the tile's
  // vertices if the kind is density, else empty.
  std::array<CellFunction, 3> in_cell(const StoredTile& tile, std::span<const std::size_t> vertices,
                                      std::span<const Point> corners, const ScaledDouble& volume,
                                      std::span<const ScaledDouble> densities) const;

 private:
  std::array<CellFunction, 3> derivative(const StoredTile& tile, std::span<const std::size_t> vertices,
                                         std::span<const Point> corners, const ScaledDouble& volume) const;

  GridKind kind_ = GridKind::density;
  int dimension_ = 3;
  std::size_t row_bytes_ = 0;
  std::vector<AttributeColumn> columns_;
};

}  // namespace tessera::density
