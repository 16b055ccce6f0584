#include "src/result/verify/against_cgal.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <string>
#include <utility>

#include "src/base/ieee_arithmetic.h"
#include "src/base/stoppable_sort.h"
#include "src/base/stopped.h"

namespace tessera {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vb3 = CGAL::Triangulation_vertex_base_with_info_3<PointId, K>;
using Dt3 = CGAL::Delaunay_triangulation_3<
    K, CGAL::Triangulation_data_structure_3<Vb3, CGAL::Delaunay_triangulation_cell_base_3<K>>>;
using Vb2 = CGAL::Triangulation_vertex_base_with_info_2<PointId, K>;
using Dt2 = CGAL::Delaunay_triangulation_2<K, CGAL::Triangulation_data_structure_2<Vb2>>;

template <class Handle>
IdSet ids_of(Handle cell, int corners) {
  IdSet ids{padding_id, padding_id, padding_id, padding_id};
  for (int k = 0; k < corners; ++k) ids[static_cast<std::size_t>(k)] = cell->vertex(k)->info();
  std::sort(ids.begin(), ids.end());
  return ids;
}

constexpr std::uint32_t steps_a_look = 1 << 14;

// Shifts images of a cell such that the one with the least id, and of its images the least, has the offset 0; and
// sorts.
void make_canonical(IdSet& ids, int corners) {
  const auto end = ids.begin() + corners;
  const auto least = std::min_element(ids.begin(), end, [](PointId a, PointId b) {
    return plain(a) != plain(b) ? plain(a) < plain(b) : offset_of(a) < offset_of(b);
  });
  const PeriodOffset shift = offset_of(*least);
  for (auto id = ids.begin(); id != end; ++id) *id = image_of(*id, offset_of(*id) - shift);
  std::sort(ids.begin(), end);
}

// CGAL inserts a range in one call, which cannot be stopped. So the points come in batches of some tenths of a second.
// The order is random, so that each batch is spread over all of space and the points inserted before give good hints.
template <class Triangulation, class Place>
void insert_all(Triangulation& to, std::vector<std::pair<Place, PointId>> points, const std::stop_token& stop) {
  StopCheck check(stop, steps_a_look);
  constexpr std::size_t batch = 1 << 14;
  std::mt19937_64 random(20200611);
  for (std::size_t i = points.size(); i > 1; --i) {
    check.step();
    std::swap(points[i - 1], points[random() % i]);
  }
  for (std::size_t begin = 0; begin < points.size(); begin += batch) {
    throw_if_stopped(stop);
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(begin);
    to.insert(first, first + static_cast<std::ptrdiff_t>(std::min(batch, points.size() - begin)));
  }
}

// The finite cells, each with sorted ids; none if the points do not span space. Throws Stopped.
std::vector<IdSet> cells_by_cgal(const std::vector<Point>& points, const std::vector<PointId>& ids, int dimension,
                                 const std::stop_token& stop) {
  StopCheck check(stop, steps_a_look);
  std::vector<IdSet> cells;
  const auto take = [&](const auto& handles, int corners) {
    for (const auto cell : handles) {
      check.step();
      cells.push_back(ids_of(cell, corners));
    }
  };
  if (dimension == 3) {
    std::vector<std::pair<K::Point_3, PointId>> input;
    input.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      input.emplace_back(K::Point_3(points[i].x, points[i].y, points[i].z), ids[i]);
    Dt3 t;
    insert_all(t, std::move(input), stop);
    if (t.dimension() == 3) take(t.finite_cell_handles(), 4);
  } else {
    std::vector<std::pair<K::Point_2, PointId>> input;
    input.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) input.emplace_back(K::Point_2(points[i].x, points[i].y), ids[i]);
    Dt2 t;
    insert_all(t, std::move(input), stop);
    if (t.dimension() == 2) take(t.finite_face_handles(), 3);
  }
  return cells;
}

}  // namespace

void AgainstCgal::add(const TileMesh& mesh) {
  const auto corners = static_cast<std::size_t>(dimension_) + 1;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.point_ghost[i] != 0) continue;
    points_.push_back(mesh.points[i]);
    ids_.push_back(mesh.ids[i]);
  }
  const auto id_of = [&](std::int32_t vertex) {
    const auto v = static_cast<std::size_t>(vertex);
    return mesh.offsets.empty() ? mesh.ids[v] : image_of(mesh.ids[v], image::offset(mesh.offsets[v]));
  };
  for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
    if (mesh.cell_ghost[c] != 0) continue;
    IdSet ids{padding_id, padding_id, padding_id, padding_id};
    for (std::size_t k = 0; k < corners; ++k) ids[k] = id_of(mesh.cells[c * corners + k]);
    if (!mesh.offsets.empty()) {
      make_canonical(ids, dimension_ + 1);
    } else {
      std::sort(ids.begin(), ids.end());
    }
    cells_.push_back(ids);
  }
}

Status AgainstCgal::compare(const std::filesystem::path& out) {
  try {
    return compare_all(out);
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while comparing with CGAL");
  }
}

void AgainstCgal::add_copies() {
  const std::size_t own = points_.size();
  for (const PeriodOffset& o : period_.offsets()) {
    if (o == PeriodOffset{}) continue;
    for (std::size_t i = 0; i < own; ++i) {
      points_.push_back(period_.shifted(points_[i], o));
      ids_.push_back(image_of(ids_[i], o));
    }
  }
}

void AgainstCgal::keep_one_copy(std::vector<IdSet>& cells) const {
  const int corners = dimension_ + 1;
  std::erase_if(cells, [&](const IdSet& ids) {
    return std::none_of(ids.begin(), ids.begin() + corners, [](PointId id) { return offset_code(id) == 0; });
  });
  for (IdSet& ids : cells) make_canonical(ids, corners);
  sort_unless_stopped(cells.begin(), cells.end(), stop_);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

Status AgainstCgal::compare_all(const std::filesystem::path& out) {
  const auto wrong = [&](const IdSet& cell, const std::string& reason) {
    return error(Errc::not_delaunay, out.string() + ": the cell of vertices " + text_of(cell) + " " + reason);
  };
  sort_unless_stopped(cells_.begin(), cells_.end(), stop_);
  if (period_.any()) add_copies();
  std::vector<IdSet> expected = cells_by_cgal(points_, ids_, dimension_, stop_);
  if (expected.empty()) return error(Errc::not_delaunay, out.string() + ": the vertices span no volume");
  if (period_.any()) keep_one_copy(expected);
  sort_unless_stopped(expected.begin(), expected.end(), stop_);
  const auto [got, want] = std::mismatch(cells_.begin(), cells_.end(), expected.begin(), expected.end());
  if (got == cells_.end() && want == expected.end()) return success();
  if (want == expected.end() || (got != cells_.end() && *got < *want))
    return wrong(*got, "is not in CGAL's triangulation");
  return wrong(*want, "is in CGAL's triangulation, but missing here");
}

}  // namespace tessera
