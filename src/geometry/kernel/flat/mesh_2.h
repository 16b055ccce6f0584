// The triangulation of the flat kernel in 2D: see mesh.h. Cells are triangles, facets are edges.
#pragma once

#include <vector>

#include "src/geometry/kernel/flat/cells_2.h"
#include "src/geometry/kernel/flat/mesh.h"

namespace tessera::flat2 {

class Mesh : public flat::MeshBase<Mesh, Cell> {
 public:
  static constexpr std::size_t cells_a_vertex = 2;
  // In the plane walks are short even in sparse rounds, so few rounds suffice. A factor of 32 between rounds is 7 %
  // faster than a factor of 8.
  static constexpr int brio_bits = 5;

  explicit Mesh(const FlatOptions& options = {}) : MeshBase(options, vertices_max) {}
  // Borrowed points are read where the caller keeps them. The first add() copies them.
  Vertex add(const Point& p);
  bool spans_more(const Point& p) const;
  bool positive(const Corners& v) const;
  bool walk(const Point& p, Index slot, Located& found) const;
  bool conflicts(const Point& p, Index slot) const;
  // Lists the zone's boundary in counterclockwise order.
  void find_zone(const Point& p, Index start);
  std::size_t zone_size() const { return zone_size_; }
  Index zone_cell(std::size_t i) const { return zone_[i]; }
  void zone_into(std::vector<Vertex>& vertices) const;
  void fill(Vertex v);
  void leave() { last_ = zone_.front(); }
  void around(Vertex v, std::vector<Index>& found) const;
  void neighbours_into(Vertex v, std::vector<Vertex>& vertices) const;
  void release_scratch();
  std::size_t memory() const;

 private:
  // An edge of the zone's boundary. It ends where the next edge begins.
  struct Edge {
    Index across;
    Vertex from;
  };
  struct Near {  // a vertex of the zone or next to it, with coordinates relative to the new point
    double x, y, lift;
    Vertex v;
  };
  struct Pending {  // an edge a to b of the zone so far, and the vertex c beyond; a, b, c are indices in near_
    Index across;
    Index a, b, c;
    bool in_conflict;  // whether the triangle beyond is in conflict
  };
  // All points are in one piece: see add().
  const Point& point(Vertex v) const { return points.first()[v]; }
  bool conflicts_with_hull(const Point& p, const Cell& t) const;

  std::vector<Index> zone_;     // [0, zone_size_) are the triangles in conflict
  std::vector<Edge> boundary_;  // [0, boundary_size_) are the edges around the zone
  std::size_t zone_size_ = 0, boundary_size_ = 0;
  std::vector<Pending> pending_;  // scratch of find_zone(), like near_
  std::vector<Near> near_;
};

}  // namespace tessera::flat2
