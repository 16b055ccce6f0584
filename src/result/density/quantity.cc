#include "src/result/density/quantity.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "src/base/option.h"
#include "src/result/query/column.h"

namespace tessera::density {
namespace {

// The same values with one exponent.
CellFunction function_of(std::span<const ScaledDouble> values) {
  CellFunction function;
  bool first = true;
  for (const ScaledDouble& value : values) {
    if (value.fraction == 0) continue;
    function.exponent = first ? value.exponent : std::max(function.exponent, value.exponent);
    first = false;
  }
  for (std::size_t k = 0; k < values.size(); ++k)
    function.values[k] = std::ldexp(values[k].fraction, values[k].exponent - function.exponent);
  return function;
}

CellFunction constant(const ScaledDouble& value, std::size_t corners) {
  CellFunction function;
  std::fill_n(function.values.begin(), corners, value.fraction);
  function.exponent = value.exponent;
  return function;
}

// a + b, or a - b if `sign` is -1.
ScaledDouble sum_of(const ScaledDouble& a, const ScaledDouble& b, int sign = 1) {
  if (b.fraction == 0) return a;
  const int exponent = a.fraction == 0 ? b.exponent : std::max(a.exponent, b.exponent);
  return ScaledDouble::of(
      std::ldexp(a.fraction, a.exponent - exponent) + sign * std::ldexp(b.fraction, b.exponent - exponent), exponent);
}

std::string option_of(GridKind kind) {
  return kind == GridKind::curl ? "curl" : kind == GridKind::shear ? "shear" : "divergence";
}

// The axes of the components of the shear, in their order.
constexpr std::array<std::array<std::size_t, 2>, 2> shear_axes_2{{{0, 0}, {0, 1}}};
constexpr std::array<std::array<std::size_t, 2>, 5> shear_axes_3{{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}}};
std::span<const std::array<std::size_t, 2>> shear_axes(int dimension) {
  if (dimension == 2) return shear_axes_2;
  return shear_axes_3;
}

}  // namespace

std::string component_suffix(GridKind kind, int dimension, std::size_t component) {
  constexpr std::string_view axes = "xyz";
  if (components_of(kind, dimension) == 1) return "";
  if (kind == GridKind::curl) return std::string("_") + axes[component];
  const auto [i, j] = shear_axes(dimension)[component];
  return std::string("_") + axes[i] + axes[j];
}

Result<Quantity> Quantity::find(const std::filesystem::path& out, const Manifest& manifest, GridKind kind,
                                const std::vector<std::string>& names) {
  Quantity quantity;
  quantity.kind_ = kind;
  quantity.dimension_ = manifest.dimension;
  quantity.row_bytes_ = row_bytes(manifest.schema);
  const auto d = static_cast<std::size_t>(manifest.dimension);
  if (kind == GridKind::field && names.size() != 1)
    return error(Errc::usage, option("field") + ": takes the name of one attribute");
  if (is_of_vector(kind) && names.size() != d)
    return error(Errc::usage, option(option_of(kind)) + ": takes the names of " + std::to_string(d) +
                                  " attributes, the components of a vector in " + std::to_string(d) + "D, but got " +
                                  std::to_string(names.size()));
  for (const std::string& name : names) {
    BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, name));
    quantity.columns_.push_back(column);
  }
  return quantity;
}

CellFunctions Quantity::in_cell(const StoredTile& tile, std::span<const std::size_t> vertices,
                                std::span<const Point> corners, const ScaledDouble& volume,
                                std::span<const ScaledDouble> densities) const {
  if (is_of_vector(kind_)) return derivative(tile, vertices, corners, volume);
  CellFunctions functions;
  std::array<ScaledDouble, 4> values;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    if (kind_ == GridKind::density) {
      values[k] = densities[vertices[k]];
      continue;
    }
    const double value = columns_[0].value(tile.rows.data() + vertices[k] * row_bytes_);
    functions[0].known = functions[0].known && std::isfinite(value);
    if (functions[0].known) values[k] = ScaledDouble::of(value);
  }
  if (functions[0].known) functions[0] = function_of(std::span(values).first(vertices.size()));
  return functions;
}

CellFunctions Quantity::derivative(const StoredTile& tile, std::span<const std::size_t> vertices,
                                   std::span<const Point> corners, const ScaledDouble& volume) const {
  Slopes by{};
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      values[k] = columns_[i].value(tile.rows.data() + vertices[k] * row_bytes_);
      if (!std::isfinite(values[k])) {
        CellFunctions unknown;
        for (auto& function : unknown) function.known = false;
        return unknown;
      }
    }
    by[i] = gradient_times_volume(corners, std::span(values).first(vertices.size()));
    for (auto& slope : by[i]) slope = slope / volume;
  }
  return of_slopes(by);
}

CellFunctions Quantity::of_slopes(const Slopes& by) const {
  const std::size_t d = columns_.size(), vertices = d + 1;
  ScaledDouble divergence;
  for (std::size_t i = 0; i < d; ++i) divergence = sum_of(divergence, by[i][i]);
  CellFunctions functions;
  if (kind_ == GridKind::divergence) {
    functions[0] = constant(divergence, vertices);
  } else if (kind_ == GridKind::shear) {
    const ScaledDouble share = divergence / ScaledDouble::of(static_cast<double>(d));
    std::size_t component = 0;
    for (const auto& [i, j] : shear_axes(dimension_)) {
      const ScaledDouble value =
          i == j ? sum_of(by[i][i], share, -1) : sum_of(by[i][j], by[j][i]) / ScaledDouble::of(2);
      functions[component++] = constant(value, vertices);
    }
  } else if (dimension_ == 2) {
    functions[0] = constant(sum_of(by[1][0], by[0][1], -1), vertices);
  } else {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      functions[i] = constant(sum_of(by[k][j], by[j][k], -1), vertices);
    }
  }
  return functions;
}

}  // namespace tessera::density
