// Voronoi cells in 2D.
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "src/geometry/mesh/image_order.h"
#include "src/result/measure/twofold.h"
#include "src/result/measure/values.h"
#include "src/result/measure/voronoi_cells.h"
#include "src/result/measure/voronoi_part.h"

namespace tessera::voronoi {
namespace {

using query::Long;
using query::Vec;
using query::Wide;

// The Voronoi cell of a vertex as one sum over the Delaunay cells around it, of the triangles from the vertex over the
// middle of an edge to the circumcentre: the flag decomposition. A triangle counts as negative where the circumcentre
// lies beyond the edge. `corners` are the neighbours relative to the vertex, counterclockwise, from a first one that
// does not depend on how they are stored; each and the next are in one Delaunay cell.
template <class Number>
VoronoiPart<Number> cell_of(std::span<const Vec<Number>> corners) {
  VoronoiPart<Number> cell;
  const Vec<Number>& first = corners.front();
  const Number first_square = query::dot(first, first), first_length = root(first_square);
  Number aa = first_square, la = first_length, first_flag = 0, flag_before = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const bool last = k + 1 == corners.size();
    const Vec<Number>&a = corners[k], &b = last ? first : corners[k + 1];
    const Number bb = last ? first_square : query::dot(b, b), lb = last ? first_length : root(bb);
    const Number twice = a.x * b.y - a.y * b.x, half = 1 / (2 * twice);
    const Number x = (aa * b.y - bb * a.y) * half, y = (bb * a.x - aa * b.x) * half;  // of the circumcentre
    const Number at_a = a.x * y - a.y * x, at_b = x * b.y - y * b.x;                  // areas times 4
    const Number both = at_a + at_b;
    cell.volume += both;
    cell.moment.x += (at_a * a.x + at_b * b.x) / 2 + both * x;
    cell.moment.y += (at_a * a.y + at_b * b.y) / 2 + both * y;
    // The edge of the Voronoi cell between it and that of a neighbour has two triangles, of which one is in each cell.
    if (k == 0)
      first_flag = at_a;
    else
      cell.surface += (flag_before + at_a) / la;
    flag_before = at_b;
    const Number sizes = la * lb, reach = sizes * (la + lb) * half;
    cell.doubt += long_of(Number((la + lb) * reach * (1 + 2 * sizes * half)));
    aa = bb;
    la = lb;
  }
  cell.surface += (flag_before + first_flag) / first_length;
  cell.doubt *= 32.0L / 4;
  cell.volume = cell.volume / 4;
  cell.moment = (Number(1) / 12) * cell.moment;
  return cell;
}

class PlanarCells {
 public:
  explicit PlanarCells(const TileMesh& mesh) : mesh_(mesh), stars_(mesh) {}

  VoronoiCell of(std::size_t vertex) {
    const auto star = stars_.of(vertex);
    if (find_ring(vertex, star)) return measured(vertex);
    const Border border = border_of(vertex, star);
    return open_cell(border == Border::none ? Border::unknown : border, count_neighbours(mesh_, vertex, star));
  }

 private:
  // Computes with as many bits as the flatness of the cells asks for.
  VoronoiCell measured(std::size_t vertex) const {
    constexpr Long accepted = 1e-15L;
    VoronoiCell cell{.neighbours = static_cast<std::uint32_t>(ring_.size())};
    const Point& at = mesh_.points[vertex];
    const auto quick = sum_of<Long>(vertex);
    if (quick.volume > 0 && std::numeric_limits<Long>::epsilon() * quick.doubt <= accepted * quick.volume) {
      fill(cell, at, 2, quick);
      return cell;
    }
    const auto finer = sum_of<Twofold>(vertex);
    if (finer.volume > 0 && Twofold::epsilon() * finer.doubt <= accepted * long_of(finer.volume))
      fill(cell, at, 2, finer);
    else
      fill(cell, at, 2, sum_of<Wide>(vertex));
    return cell;
  }

  // Finds the neighbours counterclockwise, from the least one (image_order.h): so sums over them have the same bits
  // wherever the cells are stored. Returns false when the cells around the vertex are not a ring: it is on the hull, or
  // not all cells are known.
  bool find_ring(std::size_t vertex, std::span<const std::uint32_t> star) {
    ring_.clear();
    if (star.empty()) return false;
    const auto corner_of = [&](std::uint32_t cell) {
      std::size_t k = 0;
      while (k < 2 && static_cast<std::size_t>(vertex_at(cell, k)) != vertex) ++k;
      return k;
    };
    const auto next_to = [&](std::uint32_t cell) {
      return image_order(mesh_, static_cast<std::size_t>(vertex_at(cell, (corner_of(cell) + 1) % 3)));
    };
    std::uint32_t first = star.front();
    for (const std::uint32_t cell : star)
      if (next_to(cell) < next_to(first)) first = cell;
    std::uint32_t cell = first;
    do {
      const std::size_t own = corner_of(cell);
      if (ring_.size() == star.size() || static_cast<std::size_t>(vertex_at(cell, own)) != vertex) return false;
      ring_.push_back(vertex_at(cell, (own + 1) % 3));
      const std::int32_t beyond = mesh_.neighbors[cell * 3 + (own + 1) % 3];
      if (beyond < 0) return false;
      cell = static_cast<std::uint32_t>(beyond);
    } while (cell != first);
    return ring_.size() == star.size();
  }

  // Whether an edge with the vertex is on the hull, or leads to a cell that is not known here.
  Border border_of(std::size_t vertex, std::span<const std::uint32_t> star) const {
    Border border = Border::none;
    for (const std::uint32_t cell : star) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (static_cast<std::size_t>(vertex_at(cell, k)) == vertex) continue;
        const std::int32_t beyond = mesh_.neighbors[cell * 3 + k];
        if (beyond < -1) return Border::unknown;
        if (beyond == -1) border = Border::hull;
      }
    }
    return border;
  }

  template <class Number>
  VoronoiPart<Number> sum_of(std::size_t vertex) const {
    constexpr std::size_t usual = 24;
    std::array<Vec<Number>, usual> few;
    std::vector<Vec<Number>> many;
    if (ring_.size() > usual) many.resize(ring_.size());
    const std::span<Vec<Number>> corners = ring_.size() > usual ? std::span(many) : std::span(few).first(ring_.size());
    const Point& at = mesh_.points[vertex];
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      const Point& p = mesh_.points[static_cast<std::size_t>(ring_[k])];
      corners[k].x = Number(p.x) - Number(at.x);
      corners[k].y = Number(p.y) - Number(at.y);
    }
    return cell_of<Number>(corners);
  }

  std::int32_t vertex_at(std::uint32_t cell, std::size_t k) const { return mesh_.cells[cell * 3 + k]; }

  const TileMesh& mesh_;
  const Stars stars_;
  std::vector<std::int32_t> ring_;
};

}  // namespace

Status planar_cells(const TileMesh& mesh, const std::stop_token& stop, const TakeCell& take) {
  PlanarCells cells(mesh);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.point_ghost[v] != 0) continue;
    BOOST_OUTCOME_TRYV(go_on(stop, v));
    take(v, cells.of(v));
  }
  return success();
}

}  // namespace tessera::voronoi
