#include "src/result/alpha/tile_alpha.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "src/base/stopped.h"
#include "src/geometry/mesh/images.h"
#include "src/geometry/predicates/exact/circumradius.h"

namespace tessera::alpha {

namespace {

constexpr std::size_t cells_a_look = 4096;  // between two checks for a stop

}  // namespace

std::array<std::int32_t, 3> facet_of(const TileMesh& mesh, std::size_t cell, std::size_t k) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::array<std::int32_t, 3> facet{};
  for (std::size_t i = 0, at = 0; i < corners; ++i)
    if (i != k) facet[at++] = mesh.cells[cell * corners + i];
  // Without corner k the others in their order are seen from outside when k is even, in 2D and in 3D.
  if (k % 2 != 0) std::swap(facet[corners - 3], facet[corners - 2]);
  return facet;
}

// Passes simplices on when there are some thousand.
class TileAlpha::Batch {
 public:
  Batch(const TileMesh& mesh, const Period& period, const Take& take) : mesh_(mesh), period_(period), take_(take) {}
  Status add(SimplexKind kind, std::span<const std::int32_t> vertices) {
    ShapeSimplex simplex;
    simplex.kind = kind;
    const PeriodOffset base = base_offset(mesh_, vertices);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      simplex.ids[i] = image_of(mesh_, vertices[i], base);
      simplex.at[i] = period_.shifted(mesh_.points[static_cast<std::size_t>(vertices[i])], PeriodOffset{} - base);
    }
    if (kind != SimplexKind::facet) {
      simplex.sort(vertices.size());
    } else if (vertices.size() == 3) {
      simplex.begin_with_least();
    }
    simplices_.push_back(simplex);
    return simplices_.size() < simplices_max ? success() : flush();
  }
  Status flush() {
    if (simplices_.empty()) return success();
    BOOST_OUTCOME_TRYV(take_(simplices_));
    simplices_.clear();
    return success();
  }

 private:
  static constexpr std::size_t simplices_max = 4096;
  const TileMesh& mesh_;
  const Period& period_;
  const Take& take_;
  std::vector<ShapeSimplex> simplices_;
};

// What is known of the faces that have a vertex of the tile's own.
struct TileAlpha::Faces {
  std::vector<std::uint8_t> complex;  // by cell: bit k says that the facet opposite corner k is in the complex
  std::vector<std::uint8_t> touched;  // by vertex: 1 when an edge in the complex has the vertex
};

TileAlpha::TileAlpha(const TileMesh& mesh, TileId self, const Period& period, double radius, std::stop_token stop)
    : mesh_(mesh),
      self_(self),
      period_(period),
      radius_(radius),
      stop_(std::move(stop)),
      corners_(static_cast<std::size_t>(mesh.dimension) + 1),
      in_(mesh.cell_ghost.size()) {
  std::array<Point, 4> at;
  for (std::size_t cell = 0; cell < in_.size(); ++cell) {
    look_for_stop(cell);
    for (std::size_t k = 0; k < corners_; ++k)
      at[k] = mesh_.points[static_cast<std::size_t>(mesh_.cells[cell * corners_ + k])];
    in_[cell] = exact::compare_circumradius(std::span(at).first(corners_), corners_ == 3, radius_) <= 0 ? 1 : 0;
  }
}

void TileAlpha::look_for_stop(std::size_t cell) const {
  if (cell % cells_a_look == 0 && stop_.stop_requested()) throw Stopped();
}

std::uint64_t TileAlpha::main_cells() const {
  std::uint64_t count = 0;
  for (std::size_t cell = 0; cell < in_.size(); ++cell) count += in_[cell] != 0 && mesh_.cell_ghost[cell] == 0 ? 1 : 0;
  return count;
}

Status TileAlpha::regular_facets(const Take& take) const {
  Batch batch(mesh_, period_, take);
  for (std::size_t cell = 0; cell < in_.size(); ++cell) {
    look_for_stop(cell);
    if (in_[cell] == 0) continue;
    for (std::size_t k = 0; k < corners_; ++k) {
      const std::int32_t neighbor = mesh_.neighbors[cell * corners_ + k];
      if (neighbor >= 0 && in_[static_cast<std::size_t>(neighbor)] != 0) continue;
      const auto facet = facet_of(mesh_, cell, k);
      const auto vertices = std::span(facet).first(corners_ - 1);
      if (!is_main(mesh_, vertices, self_)) continue;
      BOOST_OUTCOME_TRYV(batch.add(SimplexKind::facet, vertices));
    }
  }
  return batch.flush();
}

bool TileAlpha::in_complex(std::span<const std::int32_t> face, std::span<const std::int32_t> opposite) const {
  std::array<Point, 3> at;
  for (std::size_t i = 0; i < face.size(); ++i) at[i] = mesh_.points[static_cast<std::size_t>(face[i])];
  const auto corners = std::span<const Point>(at).first(face.size());
  const bool flat = corners_ == 3;
  if (exact::compare_circumradius(corners, flat, radius_) > 0) return false;
  return std::none_of(opposite.begin(), opposite.end(), [&](std::int32_t v) {
    return exact::in_smallest_sphere(corners, mesh_.points[static_cast<std::size_t>(v)], flat);
  });
}

Status TileAlpha::singular_faces(const Take& take) const {
  Batch batch(mesh_, period_, take);
  Faces faces{std::vector<std::uint8_t>(in_.size(), 0), std::vector<std::uint8_t>(mesh_.points.size(), 0)};
  BOOST_OUTCOME_TRYV(find_facets(faces, batch));
  if (corners_ == 4) {
    BOOST_OUTCOME_TRYV(find_edges(faces, batch));
  }
  for (std::size_t v = 0; v < faces.touched.size(); ++v) {
    if (mesh_.point_ghost[v] != 0 || faces.touched[v] != 0) continue;
    const auto vertex = static_cast<std::int32_t>(v);
    BOOST_OUTCOME_TRYV(batch.add(SimplexKind::singular_vertex, std::span(&vertex, 1)));
  }
  return batch.flush();
}

Status TileAlpha::find_facets(Faces& faces, Batch& batch) const {
  const auto is_own = [&](std::int32_t v) { return mesh_.point_ghost[static_cast<std::size_t>(v)] == 0; };
  const auto mark = [&](std::size_t cell, std::size_t k, std::span<const std::int32_t> vertices) {
    faces.complex[cell] = static_cast<std::uint8_t>(faces.complex[cell] | 1U << k);
    for (const std::int32_t v : vertices) faces.touched[static_cast<std::size_t>(v)] = 1;
  };
  for (std::size_t cell = 0; cell < in_.size(); ++cell) {
    look_for_stop(cell);
    for (std::size_t k = 0; k < corners_; ++k) {
      const auto facet = facet_of(mesh_, cell, k);
      const auto vertices = std::span<const std::int32_t>(facet).first(corners_ - 1);
      const std::int32_t neighbor = mesh_.neighbors[cell * corners_ + k];
      const auto other = static_cast<std::size_t>(neighbor);
      if (in_[cell] != 0 || (neighbor >= 0 && in_[other] != 0)) {
        mark(cell, k, vertices);
        continue;
      }
      if (neighbor >= 0 && other < cell) continue;  // was found from there
      if (std::none_of(vertices.begin(), vertices.end(), is_own)) continue;
      std::array<std::int32_t, 2> opposite{mesh_.cells[cell * corners_ + k], 0};
      std::size_t back = 0;
      if (neighbor >= 0) {
        while (back + 1 < corners_ && mesh_.neighbors[other * corners_ + back] != static_cast<std::int32_t>(cell))
          ++back;
        opposite[1] = mesh_.cells[other * corners_ + back];
      }
      if (!in_complex(vertices, std::span(opposite).first(neighbor >= 0 ? 2 : 1))) continue;
      mark(cell, k, vertices);
      if (neighbor >= 0) mark(other, back, vertices);
      if (!is_main(mesh_, vertices, self_)) continue;
      BOOST_OUTCOME_TRYV(batch.add(SimplexKind::singular_facet, vertices));
    }
  }
  return success();
}

// An edge of a cell. All cells around the edge must agree that no facet with it is in the complex, and that no vertex
// is in its smallest sphere.
Status TileAlpha::find_edges(Faces& faces, Batch& batch) const {
  struct CellEdge {
    std::int32_t a = 0, b = 0;
    bool excluded = false;
  };
  std::vector<CellEdge> edges;
  for (std::size_t cell = 0; cell < in_.size(); ++cell) {
    look_for_stop(cell);
    const auto at = std::span(mesh_.cells).subspan(cell * corners_, corners_);
    for (std::size_t i = 0; i < corners_; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const std::array<std::int32_t, 2> edge{std::min(at[i], at[j]), std::max(at[i], at[j])};
        // Own vertices come first.
        if (mesh_.point_ghost[static_cast<std::size_t>(edge[0])] != 0) continue;
        std::array<std::int32_t, 2> opposite{};
        bool covered = in_[cell] != 0;
        for (std::size_t k = 0, n = 0; k < corners_; ++k) {
          if (k == i || k == j) continue;
          opposite[n++] = at[k];
          covered = covered || (faces.complex[cell] >> k & 1U) != 0;
        }
        edges.push_back({edge[0], edge[1], covered || !in_complex(edge, opposite)});
      }
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const CellEdge& a, const CellEdge& b) { return std::tie(a.a, a.b) < std::tie(b.a, b.b); });
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    bool excluded = false;
    for (; end < edges.size() && edges[end].a == edges[begin].a && edges[end].b == edges[begin].b; ++end)
      excluded = excluded || edges[end].excluded;
    if (excluded) continue;
    const std::array<std::int32_t, 2> edge{edges[begin].a, edges[begin].b};
    for (const std::int32_t v : edge) faces.touched[static_cast<std::size_t>(v)] = 1;
    if (!is_main(mesh_, edge, self_)) continue;
    BOOST_OUTCOME_TRYV(batch.add(SimplexKind::singular_edge, edge));
  }
  return success();
}

}  // namespace tessera::alpha
