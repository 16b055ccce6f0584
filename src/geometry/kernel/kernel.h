// A Delaunay triangulation of labelled points, in 2D or 3D.
// Properties, for any order of calls:
//  (1) Equal point sets give equal cells, also for cospherical points and on the hull: ties are broken by the symbolic
//      perturbation of Devillers & Teillaud (SODA 2003), which depends on coordinates alone.
//  (2) Vertices are numbered from 1 in the order they were given; 0 is the infinite vertex. Numbers are never reused.
// Not thread-safe: one owner. Two kernels in two threads share nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/point.h"
#include "src/base/too_large.h"
#include "src/geometry/kernel/flat/memory.h"

namespace tessera {

using Vertex = std::uint32_t;
inline constexpr Vertex infinite_vertex = 0;

// Cells as arrays of d+1 vertices. Finite cells are positively oriented; an infinite one is what it would be if the
// infinite vertex stood outside the hull. neighbors[i] is the cell opposite vertices[i], as an index into the same
// list; or, once cells have been frozen, `across_frozen | (d + 1) * f + k`: there lies frozen cell f, which has its
// facet k (the one opposite its vertex k) in common with this cell.
struct CellList {
  BigVector<Vertex> vertices;
  BigVector<std::uint32_t> neighbors;
};
inline constexpr std::uint32_t across_frozen = std::uint32_t{1} << 31;

// The same, a cell a row, as the flat kernels keep them. A neighbour is 4 * row + k: there the common facet is the one
// opposite vertices[k]. In 2D the last entry of each is not used.
struct alignas(32) CellRow {
  static constexpr std::size_t most = std::size_t{1} << 29;
  static constexpr Vertex gap = ~Vertex{0};  // vertices[0] of a row without a cell
  Vertex vertices[4];
  std::uint32_t neighbors[4];
};
using CellRows = flat::Array<CellRow>;

// Cells that no point will ever be in conflict with. A kernel that hands them out and forgets them has frozen them: the
// number of a frozen cell is its row.
struct FinalCells {
  static constexpr std::uint32_t open = ~std::uint32_t{0};  // the cell across this facet is not final
  CellRows rows;                                            // without gaps; a neighbour is a row of this list, or open
  std::size_t others = 0;                                   // how many cells were left, infinite ones included
};

// Flat arrays that restore a kernel faster than building it.
struct KernelImage {
  std::vector<Point> points;        // by vertex, 1-based: points[0] belongs to vertex 1
  std::vector<std::uint8_t> local;  // by vertex: the label
  std::vector<std::uint8_t> alive;  // by vertex: 0 once removed
  CellList cells;                   // of dimension() (maximal simplices), infinite ones included
  int dimension = -1;
  std::uint32_t frozen = 0;  // cells that were frozen, and are not here
};

// Thrown when a kernel would need more cells or vertices than its indices can number: the kernel can then only be
// destroyed, built or loaded. The flat kernel holds 2^29 cells, some 79 million points in 3D.
struct KernelFull : TileTooLarge {
  KernelFull() : TileTooLarge("has more points than a kernel can number") {}
};

// Who keeps the points that build() is given. Borrowed ones are read where they are: they must neither move nor change
// until the kernel is destroyed, built or loaded again. That saves 24 bytes a point.
enum class KeepPoints : std::uint8_t { copied, borrowed };

enum class InsertMode : std::uint8_t {
  always,
  if_local_neighbour,  // not inserted when no vertex of the conflict zone is local: it would change no local star
};

struct Insertion {
  Vertex vertex = 0;  // the new vertex, or the old one with equal coordinates, or 0 when refused
  bool inserted = false;
};

class Kernel {
 public:
  virtual ~Kernel() = default;

  virtual int max_dimension() const = 0;  // 2 or 3
  // -1: no vertex; 0: one; 1: all collinear; 2: all coplanar; 3.
  virtual int dimension() const = 0;
  virtual Vertex vertices() const = 0;  // highest vertex number given so far
  virtual Point point(Vertex v) const = 0;
  virtual bool is_local(Vertex v) const = 0;

  // Builds from scratch; all points are local. `points` are distinct and best in Hilbert order: they are inserted in
  // BRIO rounds drawn from that order. Vertex i+1 is points[i]. A kernel is free to copy borrowed points. Looks at
  // `stop` some hundred times a second, and throws Stopped: the kernel can then only be destroyed, built or loaded.
  virtual void build(std::span<const Point> points, KeepPoints keep = KeepPoints::copied,
                     const std::stop_token& stop = {}) = 0;

  // Inserts a point labelled `local`. When it is inserted, or refused by `mode`, `around` becomes its neighbours (the
  // finite ones, unsorted, each once): with if_local_neighbour and a refusal, those it would have had.
  // While dimension() < max_dimension() everything is inserted, and `around` is every other vertex.
  virtual Insertion insert(const Point& p, bool local, InsertMode mode, std::vector<Vertex>& around) = 0;

  // Removes a vertex. REQUIRES: v is alive.
  virtual void remove(Vertex v) = 0;
  virtual bool alive(Vertex v) const = 0;

  // The cells around v, d+1 vertices each, infinite ones included. REQUIRES: dimension() == max_dimension().
  virtual void star(Vertex v, std::vector<Vertex>& cells) const = 0;
  // The finite vertices joined to v by an edge.
  virtual void neighbours(Vertex v, std::vector<Vertex>& around) const = 0;

  // Visits (v, w) for the edges between finite vertices that have an end from `first` on, which is v: each at least
  // once, in any order. For many v cheaper than their neighbours. REQUIRES: dimension() == max_dimension(), and no
  // vertex from `first` on has frozen cells.
  virtual void edges_from(Vertex first, const std::function<void(Vertex v, Vertex w)>& visit) const = 0;

  // All cells, infinite ones included, with neighbours. REQUIRES: dimension() == max_dimension().
  virtual CellList cells() const = 0;
  // The same as rows, some of which may be gaps. The kernel can then only be destroyed, built or loaded.
  virtual CellRows take_cells() = 0;

  // The cells that may still change. Goes from the infinite vertex and the vertices that are not local through every
  // cell that is not final; a cell with a vertex that is infinite or not local never is, the others are asked. What
  // lies behind final cells is not visited: work follows the number of open cells, not the size of the tile. Returns
  // d+1 vertices a cell. When `all` is given it becomes cells(), and `open` tells for each whether it was returned.
  // REQUIRES: dimension() == max_dimension().
  virtual std::vector<Vertex> explore(const std::function<bool(const Vertex*)>& is_final, CellList* all = nullptr,
                                      std::vector<std::uint8_t>* open = nullptr) = 0;

  // Whether freeze() is there.
  virtual bool can_freeze() const = 0;
  // Takes out the cells that explore() would not return, and forgets them: the kernel is then as small as what is left.
  // From then on the caller sees to it that no point is in conflict with a frozen cell, no vertex of one or joined to
  // one is removed, and neither star() nor neighbours() is asked of a vertex that has frozen cells. cells() tells what
  // lies across the facets of the hole.
  // REQUIRES: can_freeze(), dimension() == max_dimension(), nothing was frozen since build() or load(); and from one of
  // the cells that stay all of them can be reached through facets, as when those with a circumsphere in a convex region
  // are final and no vertex in it is not local.
  virtual FinalCells freeze(const std::function<bool(const Vertex*)>& is_final) = 0;
  // The same for a caller who keeps nothing of the frozen cells: `told` sees their vertices, d+1 a cell, some thousand
  // cells at a time. What lies across the facets of the hole is `across_frozen`, whichever cell it was. Returns how
  // many cells are gone. A third of freeze()'s time. REQUIRES: as freeze().
  using TakeVertices = std::function<void(std::span<const Vertex>)>;
  virtual std::uint64_t discard(const std::function<bool(const Vertex*)>& is_final, const TakeVertices& told) = 0;

  virtual KernelImage save() const = 0;
  // Replaces the content. The image must come from save(): it is checked for range, not for geometry; false if it
  // cannot be a triangulation.
  virtual bool load(const KernelImage& image) = 0;

  // Bytes held, an estimate within 10 %.
  virtual std::size_t memory() const = 0;
};

enum class KernelKind : std::uint8_t { cgal, flat };

std::unique_ptr<Kernel> make_kernel(int dimension, KernelKind kind = KernelKind::flat);

}  // namespace tessera
