// Asks a result and CGAL the same, many times: in which cell a point is. Exits with 1 when an answer differs.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/result/query/stored_triangulation.h"
#include "src/result/tile_source.h"

namespace {

using namespace tessera;
using K = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vb3 = CGAL::Triangulation_vertex_base_with_info_3<PointId, K>;
using Dt3 = CGAL::Delaunay_triangulation_3<
    K, CGAL::Triangulation_data_structure_3<Vb3, CGAL::Delaunay_triangulation_cell_base_3<K>>, CGAL::Fast_location>;
using Vb2 = CGAL::Triangulation_vertex_base_with_info_2<PointId, K>;
using Dt2 = CGAL::Delaunay_triangulation_2<K, CGAL::Triangulation_data_structure_2<Vb2>>;
using Ids = std::array<PointId, 4>;

template <class T>
T value(Result<T> result) {
  if (result) return std::move(result).value();
  std::cerr << "check_query: " << in_plain_words(result.error().where) << "\n";
  std::exit(1);
}

template <class Cell>
Ids ids_of(Cell cell, int d) {
  Ids ids{query::no_id, query::no_id, query::no_id, query::no_id};
  for (int k = 0; k <= d; ++k) ids[static_cast<std::size_t>(k)] = cell->vertex(k)->info();
  std::sort(ids.begin(), ids.end());
  return ids;
}

// The first, by sorted ids, of the finite cells that have the face on which CGAL finds the point; all no_id outside.
class Cgal3 {
 public:
  explicit Cgal3(const std::vector<std::pair<Point, PointId>>& points) {
    std::vector<std::pair<K::Point_3, PointId>> list;
    for (const auto& [p, id] : points) list.emplace_back(K::Point_3(p.x, p.y, p.z), id);
    dt_.insert(list.begin(), list.end());
  }
  Ids operator()(const Point& q) {
    Dt3::Locate_type type;
    int i = 0, j = 0;
    const auto cell = dt_.locate(K::Point_3(q.x, q.y, q.z), type, i, j, hint_);
    hint_ = cell;
    std::vector<Dt3::Cell_handle> cells{cell};
    if (type == Dt3::OUTSIDE_CONVEX_HULL || type == Dt3::OUTSIDE_AFFINE_HULL) cells.clear();
    if (type == Dt3::FACET) cells.push_back(cell->neighbor(i));
    if (type == Dt3::VERTEX) {
      cells.clear();
      dt_.incident_cells(cell->vertex(i), std::back_inserter(cells));
    }
    if (type == Dt3::EDGE) {
      auto around = dt_.incident_cells(cell, i, j);
      const auto begin = around;
      do cells.push_back(around);
      while (++around != begin);
    }
    Ids first{query::no_id, query::no_id, query::no_id, query::no_id};
    for (const auto c : cells)
      if (!dt_.is_infinite(c)) first = std::min(first, ids_of(c, 3));
    return first;
  }

 private:
  Dt3 dt_;
  Dt3::Cell_handle hint_;
};

class Cgal2 {
 public:
  explicit Cgal2(const std::vector<std::pair<Point, PointId>>& points) {
    std::vector<std::pair<K::Point_2, PointId>> list;
    for (const auto& [p, id] : points) list.emplace_back(K::Point_2(p.x, p.y), id);
    dt_.insert(list.begin(), list.end());
  }
  Ids operator()(const Point& q) {
    Dt2::Locate_type type;
    int i = 0;
    const auto face = dt_.locate(K::Point_2(q.x, q.y), type, i, hint_);
    hint_ = face;
    std::vector<Dt2::Face_handle> faces{face};
    if (type == Dt2::OUTSIDE_CONVEX_HULL || type == Dt2::OUTSIDE_AFFINE_HULL) faces.clear();
    if (type == Dt2::EDGE) faces.push_back(face->neighbor(i));
    if (type == Dt2::VERTEX) {
      auto around = dt_.incident_faces(face->vertex(i));
      const auto begin = around;
      do faces.push_back(around);
      while (++around != begin);
    }
    Ids first{query::no_id, query::no_id, query::no_id, query::no_id};
    for (const auto f : faces)
      if (!dt_.is_infinite(f)) first = std::min(first, ids_of(f, 2));
    return first;
  }

 private:
  Dt2 dt_;
  Dt2::Face_handle hint_;
};

// Anywhere in and around the cloud, on vertices, between two, in planes of three, and beside vertices.
std::vector<Point> questions(const std::vector<std::pair<Point, PointId>>& points, int d, std::size_t n) {
  std::mt19937_64 random(n);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Bounds bounds;
  for (const auto& point : points) bounds.add(point.first);
  std::vector<Point> list;
  for (std::size_t i = 0; i < n; ++i) {
    // By index near each other: often neighbours.
    const std::size_t at = random() % points.size();
    const auto near = [&] { return points[std::min(at + random() % 8, points.size() - 1)].first; };
    const Point a = points[at].first, b = near(), c = near();
    Point q;
    for (int axis = 0; axis < d; ++axis) {
      const double extent = bounds.hi[axis] - bounds.lo[axis];
      const double choices[] = {bounds.lo[axis] + extent * (1.1 * unit() - 0.05), a[axis], (a[axis] + b[axis]) / 2,
                                a[axis] / 2 + b[axis] / 4 + c[axis] / 4,
                                std::nextafter(a[axis], unit() < 0.5 ? bounds.lo[axis] : bounds.hi[axis])};
      q[axis] = choices[i % std::size(choices)];
    }
    list.push_back(without_negative_zero(q));
  }
  return list;
}

template <class Cgal>
std::uint64_t wrong_ones(const query::StoredTriangulation& result, const std::vector<std::pair<Point, PointId>>& points,
                         const std::vector<Point>& asked) {
  Cgal cgal(points);
  const auto cells = value(result.locate(asked, {.threads = 2}));
  std::uint64_t wrong = 0, inside = 0;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    Ids got = cells[i].vertices;
    std::sort(got.begin(), got.end());
    wrong += got != cgal(asked[i]) ? 1 : 0;
    inside += cells[i] ? 1 : 0;
  }
  std::printf("%zu questions, %llu inside, %llu wrong\n", asked.size(), static_cast<unsigned long long>(inside),
              static_cast<unsigned long long>(wrong));
  return wrong;
}

}  // namespace

int main(int argc, char** argv) {
  std::string folder;
  std::size_t n = 100'000;
  CLI::App app("Asks a result folder and CGAL the same");
  app.add_option("result", folder)->required();
  app.add_option("-n", n, "questions");
  CLI11_PARSE(app, argc, argv);
  const auto result = value(query::StoredTriangulation::open(folder, {}));
  std::vector<std::pair<Point, PointId>> points;
  const auto source = value(TileSource::open(folder));
  for (std::size_t t = 0; t < source.tiles(); ++t) {
    const auto tile = value(source.read(t, {.cells = false}));
    for (std::size_t i = 0; i < tile.mesh.ids.size(); ++i)
      if (tile.mesh.point_ghost[i] == 0) points.emplace_back(tile.mesh.points[i], tile.mesh.ids[i]);
  }
  const int d = result.manifest().dimension;
  const auto asked = questions(points, d, n);
  const auto wrong = d == 3 ? wrong_ones<Cgal3>(result, points, asked) : wrong_ones<Cgal2>(result, points, asked);
  return wrong == 0 ? 0 : 1;
}
