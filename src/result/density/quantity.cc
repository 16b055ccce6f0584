#include "src/result/density/quantity.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

Result<Quantity> Quantity::find(const std::filesystem::path& out, const Manifest& manifest, GridKind kind,
                                const std::vector<std::string>& names) {
  Quantity quantity;
  quantity.kind_ = kind;
  quantity.dimension_ = manifest.dimension;
  quantity.row_bytes_ = row_bytes(manifest.schema);
  const auto d = static_cast<std::size_t>(manifest.dimension);
  if (kind == GridKind::field && names.size() != 1)
    return error(Errc::usage, option("field") + ": takes the name of one attribute");
  if ((kind == GridKind::divergence || kind == GridKind::curl) && names.size() != d)
    return error(Errc::usage, option(kind == GridKind::curl ? "curl" : "divergence") + ": takes the names of " +
                                  std::to_string(d) + " attributes, the components of a vector in " +
                                  std::to_string(d) + "D, but got " + std::to_string(names.size()));
  for (const std::string& name : names) {
    BOOST_OUTCOME_TRY(column, query::find_column(out, manifest, name));
    quantity.columns_.push_back(column);
  }
  return quantity;
}

std::array<CellFunction, 3> Quantity::in_cell(const StoredTile& tile, std::span<const std::size_t> vertices,
                                              std::span<const Point> corners, const ScaledDouble& volume,
                                              std::span<const ScaledDouble> densities) const {
  if (kind_ == GridKind::divergence || kind_ == GridKind::curl) return derivative(tile, vertices, corners, volume);
  std::array<CellFunction, 3> functions;
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

std::array<CellFunction, 3> Quantity::derivative(const StoredTile& tile, std::span<const std::size_t> vertices,
                                                 std::span<const Point> corners, const ScaledDouble& volume) const {
  std::array<std::array<ScaledDouble, 3>, 3> by{};  // by[i][j]: component i along axis j
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      values[k] = columns_[i].value(tile.rows.data() + vertices[k] * row_bytes_);
      if (!std::isfinite(values[k])) {
        std::array<CellFunction, 3> unknown;
        for (auto& function : unknown) function.known = false;
        return unknown;
      }
    }
    by[i] = gradient_times_volume(corners, std::span(values).first(vertices.size()));
    for (auto& slope : by[i]) slope = slope / volume;
  }
  std::array<CellFunction, 3> functions;
  if (kind_ == GridKind::divergence) {
    ScaledDouble sum;
    for (std::size_t i = 0; i < columns_.size(); ++i) sum = sum_of(sum, by[i][i]);
    functions[0] = constant(sum, vertices.size());
  } else if (dimension_ == 2) {
    functions[0] = constant(sum_of(by[1][0], by[0][1], -1), vertices.size());
  } else {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      functions[i] = constant(sum_of(by[k][j], by[j][k], -1), vertices.size());
    }
  }
  return functions;
}

}  // namespace tessera::density
