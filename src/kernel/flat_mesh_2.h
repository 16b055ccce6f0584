// The triangulation of the flat kernel in 2D: triangles, points, and the insertion of one point. Knows nothing of
// labels. Properties, between any two calls:
//  (1) The triangles are the perturbed Delaunay triangulation of the vertices, infinite ones included, without those
//      that were frozen.
//  (2) Every triangle that is there is in state `plain`.
// The insertion is Bowyer's and Watson's: walk to a triangle in conflict, collect the connected conflict zone, join its
// boundary to the point, in the zone's own slots.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/kernel/flat_memory.h"
#include "src/kernel/kernel.h"

namespace tessera::flat2 {

using Word = std::uint32_t;
template <class T>
using Array = flat::Array<T>;

// A neighbour is 4 * triangle + edge: the edge it is seen through, so the way back needs no search. With `frozen_bit`
// the triangle is one that freeze() has handed out: across_frozen | 3 * number + edge.
inline constexpr Word frozen_bit = across_frozen;
inline constexpr Word triangles_max = Word{1} << 29;
inline constexpr Word vertices_max = triangles_max / 2;

enum class State : Word { plain, open, settled, dead };  // open and settled: marks of one call; dead: a free slot

// Counterclockwise. n[i] is across the edge opposite v[i], from v[i + 1] to v[i + 2]. v[0] is never infinite.
struct alignas(32) Triangle {
  Vertex v[3];
  State state;
  Word n[3];
  bool infinite() const { return v[1] == infinite_vertex || v[2] == infinite_vertex; }
  bool dead() const { return state == State::dead; }
};
static_assert(sizeof(Triangle) == 32);

inline constexpr Word next_of[3] = {1, 2, 0}, before[3] = {2, 0, 1};

struct Located {
  Word triangle = 0;  // in conflict with the point
  Vertex same = 0;    // the vertex with equal coordinates, or 0
};

class Mesh {
 public:
  Array<Triangle> triangles;

  const Point& point(Vertex v) const { return points_[v - 1]; }
  Vertex vertices() const { return vertices_; }
  // Borrowed points are read where they are, until one is added.
  void set_points(std::span<const Point> points, KeepPoints keep);
  Vertex add(const Point& p);

  // No triangles; the points stay.
  void drop_triangles();
  // The four triangles of three vertices. REQUIRES: they are not collinear; no triangles.
  void start(std::array<Vertex, 3> v);
  bool started() const { return triangles.size() > 0; }

  // Where p is. REQUIRES: started().
  Located locate(const Point& p);
  // Collects the conflict zone of p from a triangle in it: its boundary, in counterclockwise order.
  void find_zone(const Point& p, Word start);
  // The vertex at which boundary edge k begins, for k below boundary_size(); each once, the infinite one included.
  std::size_t boundary_size() const { return boundary_size_; }
  Vertex boundary_vertex(std::size_t k) const { return boundary_[k].from; }
  std::span<const Word> zone() const { return {zone_.data(), zone_size_}; }
  // Joins the boundary of the zone to v, whose zone it is.
  void fill(Vertex v);
  // Forgets the zone; the next walk starts here.
  void leave() { last_ = zone_.front(); }
  // Locates, finds and fills, for a point that is not there yet and is vertex v.
  void insert(Vertex v);
  // Takes a vertex out. False, and nothing is changed, if the others are collinear. REQUIRES: none of its triangles or
  // of their neighbours is frozen.
  bool remove(Vertex v);

  // The triangles around v, none of them frozen. Costs a pass over all triangles the first time.
  void around(Vertex v, std::vector<Word>& found) const;
  // To be called after changes to the triangles from outside: finds the free slots and a new start for the walk.
  void rebuild();
  bool conflicts(const Point& p, const Triangle& t) const;
  std::size_t live_triangles() const { return triangles.size() - free_.size(); }
  std::size_t memory() const;

 private:
  struct Edge {
    Word across;
    Vertex from;
  };
  struct Near {  // a vertex of the zone or next to it, relative to the new point
    double x, y, lift;
    Vertex v;
  };
  struct Pending {  // an edge of the zone found so far, from a to b, with the vertex c beyond; indices in near_
    Word across;
    Word a, b, c;
    bool in_conflict;  // the triangle beyond
  };
  bool walk(const Point& p, Word start, Located& found) const;
  Located search(const Point& p, Word start) const;
  bool conflicts_with_hull(const Point& p, const Triangle& t) const;
  Word near_by_chance(const Point& p) const;
  Word new_slot();
  // Makes them neighbours, both ways unless the other one is frozen.
  void link(Word triangle, Word edge, Word across);

  const Point* points_ = nullptr;  // points_[v - 1] is vertex v
  Vertex vertices_ = 0;
  Array<Point> own_;
  bool borrowed_ = false;
  std::vector<Word> free_;      // slots without a triangle
  std::vector<Word> zone_;      // [0, zone_size_): the triangles in conflict
  std::vector<Edge> boundary_;  // [0, boundary_size_): of the zone
  std::size_t zone_size_ = 0, boundary_size_ = 0;
  std::vector<Pending> pending_;  // scratch of find_zone, as the next
  std::vector<Near> near_;
  mutable Array<Word> incident_;  // by vertex
  mutable bool indexed_ = false;  // incident_ is up to date
  Word last_ = 0;                 // where the last insertion was
};

}  // namespace tessera::flat2
