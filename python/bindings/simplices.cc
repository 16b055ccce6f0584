#include "python/bindings/simplices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace tessera::python {
namespace {

template <int D>
using Matrix = std::array<std::array<double, D>, D>;

// Returns the 1-norm: the greatest sum of the absolute values of a column.
template <int D>
double norm_1(const Matrix<D>& a) {
  double greatest = 0;
  for (int column = 0; column < D; ++column) {
    double sum = 0;
    for (int row = 0; row < D; ++row) sum += std::abs(a[row][column]);
    greatest = std::max(greatest, sum);
  }
  return greatest;
}

// Returns the inverse, by cofactors. It is infinite or NaN if the determinant is zero.
Matrix<2> inverse(const Matrix<2>& a) {
  const double scale = 1 / (a[0][0] * a[1][1] - a[0][1] * a[1][0]);
  return {{{a[1][1] * scale, -a[0][1] * scale}, {-a[1][0] * scale, a[0][0] * scale}}};
}

Matrix<3> inverse(const Matrix<3>& a) {
  const auto cofactor = [&](int row, int column) {
    const int r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = (column + 1) % 3, c2 = (column + 2) % 3;
    return a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1];
  };
  Matrix<3> result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) result[row][column] = cofactor(column, row);
  }
  const double scale = 1 / (a[0][0] * result[0][0] + a[0][1] * result[1][0] + a[0][2] * result[2][0]);
  for (auto& row : result) {
    for (auto& entry : row) entry *= scale;
  }
  return result;
}

template <int D>
void transforms(std::span<const double> points, std::span<const std::int32_t> simplices, std::span<double> out) {
  constexpr double limit = 1000 * std::numeric_limits<double>::epsilon();
  const auto corner = [&](std::size_t simplex, int k) {
    return points.subspan(static_cast<std::size_t>(simplices[simplex * (D + 1) + k]) * D, D);
  };
  for (std::size_t simplex = 0; simplex < simplices.size() / (D + 1); ++simplex) {
    const auto r = corner(simplex, D);
    Matrix<D> t;
    for (int column = 0; column < D; ++column) {
      const auto p = corner(simplex, column);
      for (int row = 0; row < D; ++row) t[row][column] = p[row] - r[row];
    }
    const auto inverted = inverse(t);
    const auto mine = out.subspan(simplex * (D + 1) * D, (D + 1) * D);
    // Written so that NaN counts as degenerate.
    if (!(1 / (norm_1<D>(t) * norm_1<D>(inverted)) >= limit)) {
      std::ranges::fill(mine, std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    for (int row = 0; row < D; ++row) std::ranges::copy(inverted[row], mine.begin() + row * D);
    std::ranges::copy(r, mine.begin() + D * D);
  }
}

}  // namespace

void barycentric_transforms(std::span<const double> points, std::span<const std::int32_t> simplices, int dimension,
                            std::span<double> out) {
  if (dimension == 2) {
    transforms<2>(points, simplices, out);
  } else {
    transforms<3>(points, simplices, out);
  }
}

VertexNeighbors vertex_neighbors(std::span<const std::int32_t> simplices, int corners, std::size_t vertices) {
  // A counting sort gives the simplices of every vertex.
  std::vector<std::size_t> ends(vertices + 1, 0);
  for (const auto vertex : simplices) ++ends[static_cast<std::size_t>(vertex) + 1];
  for (std::size_t vertex = 0; vertex < vertices; ++vertex) ends[vertex + 1] += ends[vertex];
  auto next = ends;
  std::vector<std::uint32_t> incident(simplices.size());
  for (std::size_t i = 0; i < simplices.size(); ++i) {
    incident[next[static_cast<std::size_t>(simplices[i])]++] = static_cast<std::uint32_t>(i / corners);
  }

  VertexNeighbors result;
  result.starts.reserve(vertices + 1);
  result.starts.push_back(0);
  std::vector<std::int32_t> around;
  for (std::size_t vertex = 0; vertex < vertices; ++vertex) {
    around.clear();
    for (auto i = ends[vertex]; i < ends[vertex + 1]; ++i) {
      for (const auto other : simplices.subspan(static_cast<std::size_t>(incident[i]) * corners, corners)) {
        if (static_cast<std::size_t>(other) != vertex) around.push_back(other);
      }
    }
    std::ranges::sort(around);
    const auto last = std::unique(around.begin(), around.end());
    result.indices.insert(result.indices.end(), around.begin(), last);
    if (result.indices.size() > std::numeric_limits<std::int32_t>::max()) {
      throw std::length_error("vertex_neighbor_vertices: more neighbours than an int32 can count");
    }
    result.starts.push_back(static_cast<std::int32_t>(result.indices.size()));
  }
  return result;
}

}  // namespace tessera::python
