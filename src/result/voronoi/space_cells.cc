#include "src/result/voronoi/space_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/geometry/mesh/image_order.h"
#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/measure/values.h"
#include "src/result/voronoi/box_clipper.h"
#include "src/result/voronoi/exact_number.h"
#include "src/result/voronoi/polyhedron.h"
#include "src/result/voronoi/star_order.h"

namespace tessera::voronoi {

namespace {

bool is_finite_point(const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

class SpaceCells {
 public:
  SpaceCells(const TileMesh& mesh, const std::optional<Bounds>& box) : mesh_(mesh), stars_(mesh), box_(box) {
    if (box) clipper_.emplace(*box);
  }

  // Computes all circumcentres. Returns the number of a cell that is damaged, if there is one.
  Result<std::optional<std::size_t>> prepare(const std::stop_token& stop) {
    const std::size_t cells = mesh_.cell_ghost.size();
    centres_.resize(cells);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      if (cell % 4096 == 0 && stop.stop_requested()) return error(Errc::interrupted, "interrupted while making cells");
      std::array<Point, 4> at;
      for (std::size_t k = 0; k < 4; ++k) at[k] = point(mesh_.cells[cell * 4 + k]);
      if (exact::orientation_3(at[0], at[1], at[2], at[3]) <= 0) return std::optional(cell);
      centres_[cell] = circumcentre(at);
    }
    return std::optional<std::size_t>();
  }

  enum class Made : std::uint8_t { shape, thin, beyond, unbounded, outside, damaged };
  // Sets shape() and the head of the cell of a vertex.
  Made make(std::size_t vertex, CellHead& head) {
    maker_.clear();
    head = {.id = mesh_.ids[vertex].value};
    if (!find_faces(vertex)) return Made::damaged;
    head.neighbours = static_cast<std::uint32_t>(faces_.size());
    head.unbounded = unbounded_ ? 1U : 0U;
    if (const Made made = add_faces(vertex); made != Made::shape) return made;
    if (!maker_.finish(shape_)) return Made::thin;
    const PolyhedronMeasures measures = measure(shape_);
    head.size = measures.volume;
    head.surface = measures.surface;
    for (int axis = 0; axis < 3; ++axis) head.centroid[axis] = measures.centroid[axis];
    return measures.volume > 0 ? Made::shape : Made::thin;
  }
  const Polyhedron& shape() const { return shape_; }

 private:
  struct CellFace {
    std::int32_t neighbour = 0;
    std::size_t begin = 0, end = 0;  // of its corners in ring_
  };

  const Point& point(std::int32_t v) const { return mesh_.points[static_cast<std::size_t>(v)]; }

  // Finds the faces: there is one for each edge of the vertex, whose corners are the centres of the cells around the
  // edge. They come in the order of the neighbours (image_order.h), which does not depend on the tile.
  bool find_faces(std::size_t vertex) {
    edges_.clear();
    for (const std::uint32_t cell : stars_.of(vertex)) {
      const std::int32_t* corner = mesh_.cells.data() + std::size_t{cell} * 4;
      std::size_t own = 0;
      while (own < 3 && static_cast<std::size_t>(corner[own]) != vertex) ++own;
      std::array<std::int32_t, 3> other{};
      for (std::size_t k = 0, n = 0; k < 4; ++k)
        if (k != own) other[n++] = corner[k];
      if (own % 2 == 1) std::swap(other[1], other[2]);  // so that the vertex before them is an even permutation
      for (std::size_t k = 0; k < 3; ++k) edges_.push_back({other[k], {other[(k + 1) % 3], other[(k + 2) % 3], cell}});
    }
    const auto order = [&](std::int32_t v) { return image_order(mesh_, static_cast<std::size_t>(v)); };
    std::sort(edges_.begin(), edges_.end(),
              [&](const auto& a, const auto& b) { return order(a.first) < order(b.first); });
    faces_.clear();
    ring_.clear();
    unbounded_ = false;
    for (std::size_t i = 0, end = 0; i < edges_.size(); i = end) {
      wedges_.clear();
      for (; end < edges_.size() && edges_[end].first == edges_[i].first; ++end) wedges_.push_back(edges_[end].second);
      if (!order_.order(wedges_, star_)) return false;
      unbounded_ = unbounded_ || star_.on_hull;
      const std::size_t begin = ring_.size();
      for (const std::uint32_t cell : star_.cells) ring_.push_back(centres_[cell]);
      faces_.push_back({edges_[i].first, begin, ring_.size()});
    }
    return !faces_.empty();
  }

  // Gives the faces of what is left of the cell to the maker.
  Made add_faces(std::size_t vertex) {
    if (!box_ && unbounded_) return Made::unbounded;
    if (box_) {
      Bounds all;
      for (const Point& p : ring_) all.add(p);
      bool inside = !unbounded_, outside = false;
      for (int axis = 0; axis < 3; ++axis) {
        inside = inside && box_->lo[axis] <= all.lo[axis] && all.hi[axis] <= box_->hi[axis];
        outside = outside || all.hi[axis] < box_->lo[axis] || box_->hi[axis] < all.lo[axis];
      }
      if (outside && !unbounded_) return Made::outside;
      if (!inside) {
        around_.clear();
        for (const CellFace& face : faces_) around_.push_back(point(face.neighbour));
        return clipper_->clip(mesh_.points[vertex], around_, maker_) ? Made::shape : Made::outside;
      }
    }
    if (!std::all_of(ring_.begin(), ring_.end(), is_finite_point)) return Made::beyond;
    for (const CellFace& face : faces_)
      maker_.add_face(std::span<const Point>(ring_).subspan(face.begin, face.end - face.begin));
    return Made::shape;
  }

  const TileMesh& mesh_;
  const Stars stars_;
  std::optional<Bounds> box_;
  std::optional<BoxClipper> clipper_;
  std::vector<Point> centres_;  // by cell
  std::vector<std::pair<std::int32_t, Wedge>> edges_;
  std::vector<Wedge> wedges_;
  StarOrder order_;
  OrderedStar star_;
  std::vector<CellFace> faces_;
  std::vector<Point> ring_, around_;
  bool unbounded_ = false;
  PolyhedronMaker maker_;
  Polyhedron shape_;
};

}  // namespace

Result<CellCounts> add_space_cells(const TileSource& source, std::size_t index, const std::optional<Bounds>& box,
                                   CellRecords::Adder& to, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(tile, source.read(index, {.rows = true}));
  SpaceCells cells(tile.mesh, box);
  BOOST_OUTCOME_TRY(damaged, cells.prepare(stop));
  if (damaged) return not_oriented(source, index, *damaged);
  const std::size_t row = row_bytes(tile.schema);
  CellCounts counts;
  CellHead head;
  for (std::size_t v = 0; v < tile.mesh.points.size(); ++v) {
    if (tile.mesh.point_ghost[v] != 0) continue;
    if (v % 64 == 0 && stop.stop_requested()) return error(Errc::interrupted, "interrupted while making cells");
    using Made = SpaceCells::Made;
    const Made made = cells.make(v, head);
    if (made == Made::damaged)
      return error(Errc::corrupt, source.file(index).string() + ": the cells around vertex " +
                                      to_string(tile.mesh.ids[v]) + " do not surround the vertex");
    counts.outside += made == Made::outside ? 1 : 0;
    counts.shapeless += made == Made::beyond ? 1 : 0;
    counts.thin += made == Made::thin ? 1 : 0;
    counts.unbounded += made == Made::unbounded || (made == Made::shape && head.unbounded != 0) ? 1 : 0;
    if (made != Made::shape) continue;
    BOOST_OUTCOME_TRYV(
        to.add({head, std::span<const std::byte>(tile.rows).subspan(v * row, row), packed(cells.shape())}));
  }
  return counts;
}

}  // namespace tessera::voronoi
