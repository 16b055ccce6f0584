#include "tessera/delaunay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "src/front/api/errors.h"
#include "src/front/api/find_simplex.h"
#include "src/geometry/kernel/kernel.h"
#include "src/tiling/affine_basis.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile/collect.h"

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

  Impl(std::span<const double> coordinates, int dim) : dimension(dim), points(coordinates.begin(), coordinates.end()) {}
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
    TileMesh mesh =
        collect_cells(
            {dim, TileId{0}, std::move(ordered.points), std::move(ordered.ids), kernel->take_cells(), {}, {}, {}})
            .whole();
    simplices = std::move(mesh.cells);
    neighbors = std::move(mesh.neighbors);
    for (std::int32_t& v : simplices) v = static_cast<std::int32_t>(mesh.ids[static_cast<std::size_t>(v)].value);
    finder.emplace(SimplexArrays{dim, points, simplices, neighbors});
  }
};

Delaunay::Delaunay(std::span<const double> coordinates, int dimension, std::stop_token stop)
    : impl_(guarded([&] {
        if (dimension != 2 && dimension != 3) throw Failure(Cause::usage, "dimension: must be 2 or 3");
        const std::size_t length = coordinates.size(), d = static_cast<std::size_t>(dimension);
        if (length % d != 0) {
          throw Failure(Cause::usage, "the array: its length, " + std::to_string(length) +
                                          ", is not a multiple of the dimension, " + std::to_string(dimension));
        }
        if (length / d > std::numeric_limits<std::int32_t>::max())
          throw Failure(Cause::memory, "the array: has more than 2^31 points; use triangulate()");
        return std::make_unique<Impl>(coordinates, dimension, stop);
      })) {}
Delaunay::Delaunay(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Delaunay Delaunay::restore(std::span<const double> points, int dimension, std::span<const std::int32_t> simplices,
                           std::span<const std::int32_t> neighbors,
                           std::span<const std::pair<std::int32_t, std::int32_t>> duplicates) {
  return guarded([&] {
    const std::size_t d = dimension == 2 ? 2 : 3, corners = d + 1, n = points.size() / d;
    const auto below = [](std::size_t end, std::int32_t least) {
      return [=](std::int32_t i) { return i >= least && (i < 0 || static_cast<std::size_t>(i) < end); };
    };
    const auto is_point = below(n, 0);
    const bool fits = dimension == static_cast<int>(d) && points.size() % d == 0 && !simplices.empty() &&
                      simplices.size() % corners == 0 && neighbors.size() == simplices.size() &&
                      std::all_of(simplices.begin(), simplices.end(), is_point) &&
                      std::all_of(neighbors.begin(), neighbors.end(), below(simplices.size() / corners, -1)) &&
                      std::all_of(duplicates.begin(), duplicates.end(),
                                  [&](const auto& pair) { return is_point(pair.first) && is_point(pair.second); }) &&
                      std::all_of(points.begin(), points.end(), [](double x) { return std::isfinite(x); });
    if (!fits) throw Failure(Cause::usage, "these arrays are not those of a Delaunay triangulation");
    auto impl = std::make_unique<Impl>(points, dimension);
    impl->simplices.assign(simplices.begin(), simplices.end());
    impl->neighbors.assign(neighbors.begin(), neighbors.end());
    impl->duplicates.assign(duplicates.begin(), duplicates.end());
    impl->finder.emplace(SimplexArrays{dimension, impl->points, impl->simplices, impl->neighbors});
    return Delaunay(std::move(impl));
  });
}

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
    throw Failure(Cause::usage, "find_simplex: `out` must have one place for each query point");
  guarded([&] { impl_->finder->find(queries, out); });
}

}  // namespace tessera
