// The interface of a kernel: a Delaunay triangulation of labelled points, in 2D or 3D. A label says whether a point is
// local.
// Two properties hold for any order of calls:
//  (1) Equal point sets give equal cells, also for cospherical points and on the hull. Ties are broken by the symbolic
//      perturbation of Devillers & Teillaud (SODA 2003), which depends on coordinates alone.
//  (2) Vertices are numbered from 1 in the order of insertion; 0 is the infinite vertex. Numbers are never reused.
// A kernel is not thread-safe. Two kernels share nothing, so two threads may use one each.
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

// A list of cells with d+1 vertices each. Finite cells are positively oriented. The orientation of an infinite cell is
// the one that the cell would have if the infinite vertex lay outside the hull. neighbors[i] is the index of the cell
// opposite vertices[i] in the same list. Across a frozen cell neighbors[i] is `across_frozen | (d + 1) * f + k`
// instead: facet k of frozen cell f, the facet opposite its vertex k, is the common facet.
struct CellList {
  BigVector<Vertex> vertices;
  BigVector<std::uint32_t> neighbors;
};
inline constexpr std::uint32_t across_frozen = std::uint32_t{1} << 31;

// A cell as the flat kernels keep it. A neighbour is 4 * row + k: the common facet is opposite vertices[k] of that row.
// In 2D the last entry of each array is not used.
struct alignas(32) CellRecord {
  // The largest number of rows.
  static constexpr std::size_t most = std::size_t{1} << 29;
  static constexpr Vertex gap = ~Vertex{0};  // vertices[0] of a row without a cell
  Vertex vertices[4];
  std::uint32_t neighbors[4];
};
using CellRecords = flat::Array<CellRecord>;

// Final cells: no point will ever be in conflict with them. A kernel that hands such cells out and forgets them has
// frozen them. The number of a frozen cell is its row.
struct FinalCells {
  static constexpr std::uint32_t open = ~std::uint32_t{0};  // a neighbour that is not final
  CellRecords rows;        // without gaps; a neighbour is 4 * row + k in this list, or open
  std::size_t others = 0;  // the number of cells that stay in the kernel, infinite cells included
};

// The state of a kernel as flat arrays. Loading an image is faster than triangulating the points again.
struct KernelImage {
  std::vector<Point> points;        // by vertex; points[0] belongs to vertex 1
  std::vector<std::uint8_t> local;  // by vertex: the label
  std::vector<std::uint8_t> alive;  // by vertex: 0 = removed
  CellList cells;                   // all cells, infinite ones included; empty when dimension is below max_dimension()
  int dimension = -1;
  std::uint32_t frozen = 0;  // the number of frozen cells, which the image does not contain
};

// Thrown when a kernel would need more cells or vertices than its indices can number. After this exception the kernel
// can only be destroyed, built or loaded. The flat kernel holds 2^29 cells, some 79 million points in 3D.
struct KernelFull : TileTooLarge {
  KernelFull() : TileTooLarge("has more points than a kernel can number") {}
};

// Whether build() copies the points. Borrowed points are read where the caller keeps them, which saves 24 bytes a
// point. They must neither move nor change until the kernel is destroyed, built or loaded again.
enum class KeepPoints : std::uint8_t { copied, borrowed };

enum class InsertMode : std::uint8_t {
  always,
  if_local_neighbour,  // refuses a point whose conflict zone has no local vertex: it would change no local star
};

struct Insertion {
  Vertex vertex = 0;  // the new vertex; the old vertex if the coordinates are equal; 0 when the point was refused
  bool inserted = false;
};

// One triangulation. See the top of this file for the properties of all kernels.
class Kernel {
 public:
  virtual ~Kernel() = default;

  virtual int max_dimension() const = 0;  // 2 or 3
  // -1: no vertex. 0: one vertex. 1: all vertices are collinear. 2: all are coplanar. 3: they span space.
  virtual int dimension() const = 0;
  virtual Vertex vertices() const = 0;  // the highest vertex number given so far
  virtual Point point(Vertex v) const = 0;
  virtual bool is_local(Vertex v) const = 0;

  // Builds the triangulation of `points` from scratch. All points are local, and points[i] becomes vertex i+1. The
  // kernel inserts the points in BRIO rounds drawn from their order. A kernel is free to copy borrowed points. build()
  // looks at `stop` some hundred times a second and throws Stopped. After that the kernel can only be destroyed, built
  // or loaded.
  // REQUIRES: points are distinct. Hilbert order makes build() fast.
  virtual void build(std::span<const Point> points, KeepPoints keep = KeepPoints::copied,
                     const std::stop_token& stop = {}) = 0;

  // Inserts a point with the label `local`. When the point is inserted, or refused by `mode`, `around` becomes the list
  // of its finite neighbours, unsorted, each once. The neighbours of a refused point are those that the point would
  // have had. While dimension() < max_dimension() every point is inserted, and `around` is every other vertex.
  virtual Insertion insert(const Point& p, bool local, InsertMode mode, std::vector<Vertex>& around) = 0;

  // Removes a vertex. REQUIRES: v is alive.
  virtual void remove(Vertex v) = 0;
  virtual bool alive(Vertex v) const = 0;

  // Sets `cells` to the cells around v, d+1 vertices each, infinite cells included.
  // REQUIRES: dimension() == max_dimension().
  virtual void star(Vertex v, std::vector<Vertex>& cells) const = 0;
  // Sets `around` to the finite vertices that an edge joins to v.
  virtual void neighbours(Vertex v, std::vector<Vertex>& around) const = 0;

  // Calls visit(v, w) for each edge between finite vertices of which one end, v, has a number of `first` or above. The
  // order is arbitrary, and an edge may come more than once. For many v this is cheaper than neighbours().
  // REQUIRES: dimension() == max_dimension(), and no vertex from `first` on has frozen cells.
  virtual void edges_from(Vertex first, const std::function<void(Vertex v, Vertex w)>& visit) const = 0;

  // All cells with their neighbours, infinite cells included. REQUIRES: dimension() == max_dimension().
  virtual CellList cells() const = 0;
  // The same cells as rows, some of which may be gaps. The kernel can then only be destroyed, built or loaded.
  virtual CellRecords take_cells() = 0;

  // Returns the open cells, d+1 vertices a cell: those that may still change. A cell with an infinite or foreign vertex
  // is open; `is_final` answers for other cells. The search begins at the infinite vertex and the foreign vertices and
  // passes through open cells only. It does not visit what lies behind final cells, so its time follows the number of
  // open cells, not the size of the tile. When `all` is given, `all` becomes cells(), and `open` says of each of these
  // cells whether it was returned.
  // REQUIRES: dimension() == max_dimension(); `open` is given when `all` is.
  virtual std::vector<Vertex> explore(const std::function<bool(const Vertex*)>& is_final, CellList* all = nullptr,
                                      std::vector<std::uint8_t>* open = nullptr) = 0;

  // Whether the kernel has freeze() and discard().
  virtual bool can_freeze() const = 0;
  // Takes out the cells that explore() would not return, and forgets them. The kernel then needs memory only for the
  // other cells, and cells() says which frozen cells lie across the facets of the hole. From then on the caller
  // promises three things: no point is in conflict with a frozen cell; no vertex is removed that has a frozen cell or
  // is joined to such a vertex; star() and neighbours() are not called for a vertex that has frozen cells.
  // REQUIRES: can_freeze(), dimension() == max_dimension(), and nothing was frozen since build() or load(). The cells
  // that stay are connected through facets. This is so when the final cells are those with a circumsphere in a convex
  // region, and no foreign vertex lies in that region.
  virtual FinalCells freeze(const std::function<bool(const Vertex*)>& is_final) = 0;
  // Freezes cells for a caller that does not keep them: `told` gets the vertices of the frozen cells, d+1 a cell, some
  // thousand cells at a time. Across each facet of the hole cells() then has plain `across_frozen`, for every frozen
  // cell. Returns the number of frozen cells. Takes a third of the time of freeze(). REQUIRES: the same as freeze().
  using TakeVertices = std::function<void(std::span<const Vertex>)>;
  virtual std::uint64_t discard(const std::function<bool(const Vertex*)>& is_final, const TakeVertices& told) = 0;

  // Returns a copy, which borrows no points. Faster than save() and load(). REQUIRES: nothing is frozen.
  virtual std::unique_ptr<Kernel> clone() const = 0;
  // For readers of a kernel that nobody changes meanwhile: cells as rows, from 0 to rows() - 1, some of which may be
  // gaps. Unlike other functions these may be called from several threads. rows() is 0 for a kernel that has no rows.
  virtual std::uint32_t rows() const = 0;
  virtual CellRecord row(std::uint32_t number) const = 0;

  virtual KernelImage save() const = 0;
  // Replaces the content of the kernel. The image must come from save(). load() checks ranges, not geometry, and
  // returns false for an image that cannot be a triangulation.
  virtual bool load(const KernelImage& image) = 0;

  // The bytes that the kernel holds, estimated within 10 %.
  virtual std::size_t memory() const = 0;
};

enum class KernelKind : std::uint8_t { cgal, flat };

std::unique_ptr<Kernel> make_kernel(int dimension, KernelKind kind = KernelKind::flat);

}  // namespace tessera
