#include "tessera/delaunay.h"

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "src/api/errors.h"
#include "src/api/find_simplex.h"
#include "src/kernel/kernel.h"
#include "src/tile/collect.h"
#include "src/tiling/routed_run.h"
#include "src/tiling/span_finder.h"

namespace tessera {
namespace {

std::vector<LocalPoint> labelled(std::span<const double> coordinates, int dimension) {
  const auto d = static_cast<std::size_t>(dimension);
  std::vector<LocalPoint> points(coordinates.size() / d);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double* p = &coordinates[i * d];
    const Point at{p[0], p[1], d == 3 ? p[2] : 0};
    for (int axis = 0; axis < dimension; ++axis) {
      if (std::isfinite(at[axis])) continue;
      throw Failure(Cause::bad_input, "the array, row " + std::to_string(i) + ": " + "xyz"[axis] + " is " +
                                          (std::isnan(at[axis]) ? "nan"
                                           : at[axis] > 0       ? "infinite"
                                                                : "-infinite"));
    }
    points[i] = {without_negative_zero(at), PointId{i}};
  }
  return points;
}

}  // namespace

struct Delaunay::Impl {
  int dimension;
  std::vector<double> points;
  BigVector<std::int32_t> simplices, neighbors;
  std::vector<std::pair<std::int32_t, std::int32_t>> duplicates;
  std::optional<SimplexFinder> finder;

  Impl(std::span<const double> coordinates, int dim, const std::stop_token& stop)
      : dimension(dim), points(coordinates.begin(), coordinates.end()) {
    LoadedTile ordered = order_points(labelled(coordinates, dim), dim);
    for (const auto& [duplicate, kept] : ordered.duplicates) {
      duplicates.emplace_back(static_cast<std::int32_t>(duplicate.value), static_cast<std::int32_t>(kept.value));
    }
    const auto kernel = make_kernel(dim);
    kernel->build(ordered.points, KeepPoints::borrowed, stop);
    if (kernel->dimension() < dim) {
      throw_failure(error(Errc::bad_input, "the array: " + why_flat(points.size() / static_cast<std::size_t>(dim),
                                                                    kernel->dimension(), dim)));
    }
    TileMesh mesh = make_mesh({dim, TileId{0}, ordered.points, ordered.ids, kernel->take_cells(), {}, {}, {}});
    simplices = std::move(mesh.cells);
    neighbors = std::move(mesh.neighbors);
    for (std::int32_t& v : simplices) v = static_cast<std::int32_t>(ordered.ids[static_cast<std::size_t>(v)].value);
    finder.emplace(SimplexArrays{dim, points, simplices, neighbors});
  }
};

Delaunay::Delaunay(std::span<const double> coordinates, int dimension, std::stop_token stop)
    : impl_(guarded([&] {
        if (dimension != 2 && dimension != 3) throw Failure(Cause::usage, "dimension: must be 2 or 3");
        const std::size_t length = coordinates.size(), d = static_cast<std::size_t>(dimension);
        if (length % d != 0) {
          throw Failure(Cause::usage, "the array: its length, " + std::to_string(length) +
                                          ", is no multiple of the dimension, " + std::to_string(dimension));
        }
        if (length / d > std::numeric_limits<std::int32_t>::max())
          throw Failure(Cause::memory, "the array: has more than 2^31 points; use triangulate()");
        return std::make_unique<Impl>(coordinates, dimension, stop);
      })) {}
Delaunay::~Delaunay() = default;
Delaunay::Delaunay(Delaunay&&) noexcept = default;
Delaunay& Delaunay::operator=(Delaunay&&) noexcept = default;

int Delaunay::dimension() const { return impl_->dimension; }
std::span<const double> Delaunay::points() const { return impl_->points; }
std::span<const std::int32_t> Delaunay::simplices() const { return impl_->simplices; }
std::span<const std::int32_t> Delaunay::neighbors() const { return impl_->neighbors; }
std::span<const std::pair<std::int32_t, std::int32_t>> Delaunay::duplicates() const { return impl_->duplicates; }

void Delaunay::find_simplex(std::span<const double> queries, std::span<std::int32_t> out) const {
  if (queries.size() != out.size() * static_cast<std::size_t>(dimension()))
    throw Failure(Cause::usage, "find_simplex: there is not one place in `out` for each query point");
  guarded([&] { impl_->finder->find(queries, out); });
}

}  // namespace tessera
