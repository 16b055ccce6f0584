// The triangulation of the flat kernel in 3D: cells, points, and the insertion of one point. Knows nothing of labels.
// Properties, between any two calls:
//  (1) The cells are the perturbed Delaunay triangulation of the vertices, infinite cells included, without those that
//      were frozen.
//  (2) No mark is set and no vertex has a local number.
// The insertion is Bowyer's and Watson's: walk to a cell in conflict, collect the connected conflict zone, put the
// cells that join its boundary to the point into its slots.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/kernel/flat_cells.h"
#include "src/kernel/flat_memory.h"

namespace tessera::flat {

// Points by vertex number. The first may be the caller's own, read where they are.
class Points {
 public:
  const Point& operator[](Vertex v) const { return (v <= borrowed_ ? low_ : high_)[v]; }
  // first()[v] is the same when in_one_piece(), which saves a choice in the innermost loops.
  const Point* first() const { return low_; }
  bool in_one_piece() const { return size_ == borrowed_; }
  Vertex size() const { return size_; }
  void borrow(std::span<const Point> points);
  void copy(std::span<const Point> points);
  Vertex add(const Point& p);
  std::size_t memory() const { return own_.bytes(); }

 private:
  const Point* low_ = nullptr;   // low_[v] is vertex v for v in 1..borrowed_
  const Point* high_ = nullptr;  // high_[v] is vertex v for the others
  Vertex borrowed_ = 0, size_ = 0;
  Array<Point> own_;
};

struct Located {
  Word cell = 0;    // in conflict with the point
  Vertex same = 0;  // the vertex with equal coordinates, or 0
};

class Mesh {
 public:
  Points points;
  Array<Cell> cells;

  // No cells, no vertices.
  void clear();
  void drop_cells();
  // The cells, which leave the mesh. To be followed by new ones and rebuild().
  Array<Cell> take_cells();
  // The five cells of four vertices. REQUIRES: they are not coplanar; no cells.
  void start(std::array<Vertex, 4> v);
  bool started() const { return cells.size() > 0; }

  // Where p is. Ends at a cell in conflict with p, unless p is there already. REQUIRES: started().
  Located locate(const Point& p) const;
  // Collects the conflict zone of p from a cell in it, and its vertices. To be followed by fill() or leave().
  void find_zone(const Point& p, Word start);
  // The vertices of the zone, each once, the infinite one included.
  std::span<const Vertex> zone_vertices() const { return {zone_vertices_.data(), zone_vertices_size_}; }
  // Joins the zone's boundary to v, whose point it is the zone of.
  void fill(Vertex v);
  // Forgets the zone; the next walk starts here.
  void leave();
  // Takes a vertex out. False, and nothing is changed, if the others are coplanar. REQUIRES: none of its cells'
  // neighbours are frozen.
  bool remove(Vertex v);
  // Locates, finds and fills, for a point that is not there yet and is vertex v.
  void insert(Vertex v);

  std::size_t zone_size() const { return zone_size_; }
  Word zone_cell(std::size_t i) const { return zone_[i] >> 2; }

  // A cell around v, which is alive.
  Word incident(Vertex v) const;
  // The cells around v, none of them frozen.
  void around(Vertex v, std::vector<Word>& found) const;
  // To be called after changes to the cells from outside: finds the free slots and a new start for the walk.
  void rebuild();
  // Moves the last cells into free slots, so that there are none. Slot numbers change.
  void compact();

  // Whether p is in conflict with a cell, which may be marked: exact and perturbed.
  bool conflicts(const Point& p, Word cell) const;
  Vertex vertex(Word cell, int i) const { return cells[cell].v[i] & vertex_mask; }
  std::size_t live_cells() const { return cells.size() - free_.size(); }
  void set_frozen(bool frozen) { frozen_ = frozen; }
  bool frozen() const { return frozen_; }
  // Four vertices that are not coplanar; their points stay known when they are removed.
  std::array<Vertex, 4> simplex{};
  std::size_t memory() const;

  // The vector path is chosen at run time; the plain one for tests.
  void use_vectors(bool wanted);

 private:
  struct Facet {  // of the zone's boundary: the cell to be is (p, v[0], v[1], v[2])
    Word v[3];
    Word across;
    Word number[4];  // of the three, as in number_
  };
  struct Edge {
    std::uint64_t key;  // from << 32 | to, or 0
    Word facet;
  };
  struct Step {
    Word slot;
    Word from;  // the facet come through, 8 at the start
    bool arrived;
  };
  Step walk_surely(const Point& p, Step step) const;
  bool walk(const Point& p, Word start, Located& found) const;
  Located search(const Point& p, Word start) const;
  Word near_by_chance(const Point& p) const;
  static void put(Cell* all, Word slot, const Facet& facet, Vertex v);
  void link_small(Word facets, Vertex v);
  void link_large(Word facets, Vertex v);
  Word new_slot();
  void take_slots(Word facets);

  friend struct ZoneCode;  // flat_zone_3.cc

  std::vector<Word> free_;     // slots without a cell
  std::vector<Word> zone_;     // [0, zone_size_): cells in conflict, each with the facet it was reached through
  std::vector<Word> pending_;  // cells to be asked, in the order they were met
  std::vector<Facet> facets_;  // [0, facets_size_): the zone's boundary
  std::size_t zone_size_ = 0, facets_size_ = 0, zone_vertices_size_ = 0;
  std::vector<Word> slots_;            // of the new cells, by facet
  std::vector<Vertex> zone_vertices_;  // [0, zone_vertices_size_)
  std::vector<std::uint8_t> number_;   // by vertex: 1.. (255 at most) while it is in zone_vertices_, else 0
  std::vector<Edge> edges_;            // hash table of a large boundary
  bool frozen_ = false;                // some cells are gone
  bool vectors_ = true;
  Word last_ = 0;  // where the last insertion was
  mutable std::uint32_t turn_ = 0;  // of walks
  static constexpr std::size_t small = 64;
  alignas(64) std::array<Word, small * small> table_;  // by directed edge of a small boundary, in local numbers
};

}  // namespace tessera::flat
