#include "tests/query/query_testing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "src/geometry/predicates/independent/predicates.h"
#include "src/geometry/reference/clouds.h"

namespace tessera::test {
namespace {

// Of the facet opposite each vertex; the cell may be of any orientation.
bool has(const std::vector<Point>& points, const IdCell& cell, int dimension, const Point& q) {
  std::vector<Point> p;
  for (int k = 0; k <= dimension; ++k) p.push_back(points[cell[static_cast<std::size_t>(k)].value]);
  const auto side = [&] {
    return dimension == 3 ? independent::orientation_3(p[0], p[1], p[2], p[3])
                          : independent::orientation_2(p[0], p[1], p[2]);
  };
  const int whole = side();
  for (auto& corner : p) {
    const Point kept = corner;
    corner = q;
    if (side() == -whole) return false;
    corner = kept;
  }
  return true;
}

}  // namespace

double plane_at(const Point& p) { return 3 + 0.5 * p.x - 2 * p.y + 0.25 * p.z; }
float wave_at(const Point& p) { return static_cast<float>(std::sin(7 * p.x) + std::cos(5 * p.y + 3 * p.z)); }

std::vector<SampleKind> sample_kinds() {
  std::vector<SampleKind> kinds;
  for (const auto& cloud : cloud_kinds()) {
    for (const int dimension : {2, 3}) {
      kinds.push_back({.cloud = cloud, .dimension = dimension, .number = 1});
      kinds.push_back({.cloud = cloud, .dimension = dimension, .number = 5});
      kinds.push_back({.cloud = cloud, .dimension = dimension, .tiles = Tiles::random, .number = 4});
      kinds.push_back({.cloud = cloud, .dimension = dimension, .number = 3, .neighbors = false});
    }
  }
  return kinds;
}

QuerySample::QuerySample(const SampleKind& kind, std::size_t n) : dimension_(kind.dimension) {
  const auto cloud = make_cloud(kind.cloud, dimension_, n, 7);
  points_.resize(cloud.size());
  for (const auto& p : cloud) points_[p.id.value] = p.at;
  cells_ = global_delaunay(cloud, dimension_);
  const auto meshes = kind.tiles == Tiles::slabs
                          ? sample_tiles(points_, dimension_, kind.number)
                          : sample_tiles(points_, dimension_, kind.number, [&](std::size_t i) {
                              return static_cast<std::uint32_t>(i * 2654435761u >> 7) % kind.number;
                            });
  owners_.resize(points_.size());
  for (const auto& mesh : meshes)
    for (std::size_t i = 0; i < mesh.ids.size(); ++i) owners_[mesh.ids[i].value] = mesh.owners[i];
  const StoreOptions options{.neighbors = kind.neighbors,
                             .schema = {{"wave", AttributeType::f32}, {"plane", AttributeType::f64}}};
  store_sample(out(), meshes, options, {}, [](const TileMesh& mesh) {
    std::vector<std::byte> rows(mesh.points.size() * 12);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      const float wave = wave_at(mesh.points[i]);
      const double plane = plane_at(mesh.points[i]);
      std::memcpy(&rows[12 * i], &wave, sizeof wave);
      std::memcpy(&rows[12 * i + 4], &plane, sizeof plane);
    }
    return rows;
  });
}

const IdCell* QuerySample::right_cell(const Point& q) const {
  for (const auto& cell : cells_)  // in the order of their sorted indices
    if (has(points_, cell, dimension_, q)) return &cell;
  return nullptr;
}

std::vector<Point> QuerySample::questions(std::size_t n, unsigned seed) const {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Bounds bounds;
  for (const Point& p : points_) bounds.add(p);
  std::vector<Point> questions;
  for (std::size_t i = 0; i < n; ++i) {
    const IdCell& cell = cells_[random() % cells_.size()];
    const Point& a = points_[cell[0].value];
    const Point& b = points_[cell[1].value];
    const Point& c = points_[cell[2].value];
    Point q;
    for (int axis = 0; axis < dimension_; ++axis) {
      const double extent = bounds.hi[axis] - bounds.lo[axis];
      switch (i % 6) {
        case 0:
          q[axis] = bounds.lo[axis] + extent * (1.2 * unit() - 0.1);
          break;
        case 1:
          q[axis] = a[axis];
          break;
        case 2:
          q[axis] = (a[axis] + b[axis]) / 2;
          break;
        case 3:
          q[axis] = a[axis] / 4 + b[axis] / 4 + c[axis] / 2;
          break;
        case 4:
          q[axis] = std::nextafter(a[axis], unit() < 0.5 ? bounds.lo[axis] : bounds.hi[axis]);
          break;
        default:
          q[axis] = a[axis] + (b[axis] - a[axis]) * 2 - (c[axis] - b[axis]);
      }
    }
    questions.push_back(without_negative_zero(q));
  }
  return questions;
}

query::StoredTriangulation QuerySample::open(std::uint64_t memory_bytes) const {
  auto opened = query::StoredTriangulation::open(out(), {.memory_bytes = memory_bytes});
  if (!opened) throw std::runtime_error(opened.error().where);
  return std::move(opened).value();
}

IdCell ids_of(const query::Cell& cell) {
  IdCell ids = cell.vertices;
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace tessera::test
