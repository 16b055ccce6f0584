#include "tessera/questions.h"

#include <cmath>
#include <utility>

#include "src/front/api/errors.h"
#include "src/front/api/tile_impl.h"
#include "src/job/machine.h"
#include "src/result/query/area.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera {

struct Questions::Impl {
  Triangulation of;  // keeps a temporary result folder in existence
  query::StoredTriangulation stored;
  unsigned threads;

  int dimension() const { return stored.manifest().dimension; }
  std::size_t corners() const { return static_cast<std::size_t>(dimension()) + 1; }
  query::AskOptions asking(std::stop_token stop) const { return {.threads = threads, .stop = std::move(stop)}; }
  std::vector<Point> points_of(std::span<const double> coordinates) const;
  Tile cells_of(const query::Area& area, std::uint64_t cells_max, std::stop_token stop) const;
};

namespace {

[[noreturn]] void refuse(const std::string& why) { throw_failure(error(Errc::usage, why)); }

}  // namespace

std::vector<Point> Questions::Impl::points_of(std::span<const double> coordinates) const {
  const auto d = static_cast<std::size_t>(dimension());
  if (coordinates.size() % d != 0)
    refuse("points: " + std::to_string(coordinates.size()) + " coordinates are no points of " + std::to_string(d) +
           " dimensions");
  std::vector<Point> points(coordinates.size() / d);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t axis = 0; axis < d; ++axis) points[i][static_cast<int>(axis)] = coordinates[i * d + axis];
    if (!is_finite(points[i])) refuse("points: row " + std::to_string(i) + " is not finite");
    points[i] = without_negative_zero(points[i]);
  }
  return points;
}

Questions::Questions(const Triangulation& triangulation, std::uint64_t memory_bytes, unsigned threads)
    : impl_(guarded([&] {
        const query::OpenOptions usual;
        auto stored = value_or_throw(query::StoredTriangulation::open(
            triangulation.folder(), {.memory_bytes = memory_bytes > 0 ? memory_bytes : usual.memory_bytes,
                                     .parts = false,
                                     .periods = Periods::known}));
        return std::make_shared<const Impl>(
            Impl{triangulation, std::move(stored), threads > 0 ? threads : usable_processors()});
      })) {}

Located Questions::locate(std::span<const double> points, std::stop_token stop) const {
  return guarded([&] {
    const auto cells = value_or_throw(impl_->stored.locate(impl_->points_of(points), impl_->asking(std::move(stop))));
    Located located;
    for (const auto& cell : cells) {
      located.tiles.push_back(cell ? static_cast<std::int64_t>(cell.tile.value) : -1);
      located.cells.push_back(cell.cell);
      for (std::size_t k = 0; k < impl_->corners(); ++k)
        located.vertices.push_back(cell ? static_cast<std::int64_t>(cell.vertices[k].value) : -1);
    }
    return located;
  });
}

Star Questions::star(std::uint64_t vertex, std::optional<std::uint32_t> tile, std::stop_token stop) const {
  return guarded([&] {
    std::optional<TileId> owner;
    if (tile) owner = TileId{*tile};
    const auto found = value_or_throw(impl_->stored.star(PointId{vertex}, owner, impl_->asking(std::move(stop))));
    Star star{.vertex = found.vertex.id.value,
              .tile = found.vertex.owner.value,
              .point = {found.vertex.at.x, found.vertex.at.y, found.vertex.at.z},
              .voronoi_volume = found.voronoi_volume,
              .neighbors = {},
              .cells = {},
              .cell_tiles = {}};
    for (const auto& neighbor : found.neighbors) star.neighbors.push_back(neighbor.id.value);
    for (const auto& cell : found.cells) {
      star.cell_tiles.push_back(cell.tile.value);
      for (std::size_t k = 0; k < impl_->corners(); ++k) star.cells.push_back(cell.vertices[k].value);
    }
    return star;
  });
}

std::vector<std::uint64_t> Questions::neighbours(std::uint64_t vertex, std::optional<std::uint32_t> tile,
                                                 std::stop_token stop) const {
  return guarded([&] {
    std::optional<TileId> owner;
    if (tile) owner = TileId{*tile};
    const auto found = value_or_throw(impl_->stored.neighbours(PointId{vertex}, owner, impl_->asking(std::move(stop))));
    std::vector<std::uint64_t> ids;
    for (const PointId id : found.ids) ids.push_back(id.value);
    return ids;
  });
}

Tile Questions::Impl::cells_of(const query::Area& area, std::uint64_t cells_max, std::stop_token stop) const {
  auto set = value_or_throw(stored.cells(area, {.cells_max = cells_max}, asking(std::move(stop))));
  return TileMaker::make(std::numeric_limits<std::uint32_t>::max(), std::move(set.mesh));
}

Tile Questions::cells_of_box(std::span<const double> box, std::uint64_t cells_max, std::stop_token stop) const {
  return guarded([&] {
    const auto d = static_cast<std::size_t>(impl_->dimension());
    if (box.size() != 2 * d) refuse("bbox: must have " + std::to_string(2 * d) + " numbers");
    query::Area area;
    for (std::size_t axis = 0; axis < d; ++axis) {
      const double low = box[axis], high = box[d + axis];
      if (!(low <= high)) refuse("bbox: its lower bounds must not be above its upper ones");
      area.box.lo[static_cast<int>(axis)] = low;
      area.box.hi[static_cast<int>(axis)] = high;
    }
    if (d == 2) area.box.lo.z = area.box.hi.z = 0;
    return impl_->cells_of(area, cells_max, std::move(stop));
  });
}

Tile Questions::cells_of_polygons(const std::string& geojson, std::uint64_t cells_max, std::stop_token stop) const {
  return guarded([&] {
    auto polygon = value_or_throw(query::Polygon::of_geojson(geojson, "polygon"));
    const auto& manifest = impl_->stored.manifest();
    or_throw(polygon.place().check_in(manifest.crs, manifest.bounds));
    constexpr double inf = std::numeric_limits<double>::infinity();
    query::Area area{.box = polygon.bounds(), .polygon = std::nullopt};
    area.box.lo.z = -inf;
    area.box.hi.z = inf;
    area.polygon = std::move(polygon);
    return impl_->cells_of(area, cells_max, std::move(stop));
  });
}

Interpolated Questions::interpolate(std::span<const double> points, const std::string& value, Method method,
                                    bool weights, std::stop_token stop) const {
  return guarded([&] {
    const query::InterpolateOptions what{
        .value = value,
        .method = method == Method::natural ? query::Method::natural : query::Method::linear,
        .weights = weights};
    const auto found =
        value_or_throw(impl_->stored.interpolate(impl_->points_of(points), what, impl_->asking(std::move(stop))));
    Interpolated answer;
    if (weights) answer.offsets.push_back(0);
    for (const auto& one : found) {
      answer.values.push_back(one.value);
      if (!weights) continue;
      for (const PointId id : one.vertices) answer.vertices.push_back(id.value);
      answer.weights.insert(answer.weights.end(), one.weights.begin(), one.weights.end());
      answer.offsets.push_back(answer.vertices.size());
    }
    return answer;
  });
}

}  // namespace tessera
