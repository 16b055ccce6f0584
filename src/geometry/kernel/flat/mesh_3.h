// The triangulation of the flat kernel in 3D: see mesh.h. Between two calls every entry of number_ is 0.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/geometry/kernel/flat/cells_3.h"
#include "src/geometry/kernel/flat/mesh.h"

namespace tessera::flat3 {

class Mesh : public flat::MeshBase<Mesh, Cell> {
 public:
  static constexpr std::size_t cells_a_vertex = 8;
  static constexpr int brio_bits = 3;

  explicit Mesh(const FlatOptions& options = {});
  void drop_cells();
  Vertex add(const Point& p) { return points.add(p); }
  bool spans_more(const Point& p) const;
  bool positive(const Corners& v) const;
  bool walk(const Point& p, Index slot, Located& found) const;
  bool conflicts(const Point& p, Index slot) const;
  void find_zone(const Point& p, Index start);
  std::size_t zone_size() const { return zone_size_; }
  Index zone_cell(std::size_t i) const { return zone_[i] >> 2; }
  void zone_into(std::vector<Vertex>& vertices) const;
  void fill(Vertex v);
  void leave();
  void around(Vertex v, std::vector<Index>& found) const;
  void neighbours_into(Vertex v, std::vector<Vertex>& vertices) const;
  void release_scratch();
  std::size_t memory() const;

 private:
  struct Facet {  // of the zone's boundary; its new cell is (p, v[0], v[1], v[2])
    Index v[3];
    Index across;
    Index number[4];  // the numbers of the three vertices, as in number_
  };
  // An entry of the hash table of directed edges.
  struct Edge {
    std::uint64_t key;  // from << 32 | to; 0: a free entry
    Index facet;
  };
  // A position of a walk.
  struct WalkStep {
    Index slot;
    Index from;  // the facet through which the walk came; 8 at the start
    bool arrived;
  };
  WalkStep walk_surely(const Point& p, WalkStep step) const;
  // The vertices of the zone, each once, including the infinite vertex.
  std::span<const Vertex> zone_vertices() const { return {zone_vertices_.data(), zone_vertices_size_}; }
  static void put(Cell* all, Index slot, const Facet& facet, Vertex v);
  void link_small(Index facets, Vertex v);
  void link_large(Index facets, Vertex v);
  void take_slots(Index facets);
  void reserve_numbers() const;

  friend struct ZoneCode;  // zone_3.cc

  std::vector<Index> zone_;     // [0, zone_size_): cells in conflict, each with the facet through which it was reached
  std::vector<Index> pending_;  // cells to be asked, in the order in which they were met
  std::vector<Facet> facets_;   // [0, facets_size_) are the facets around the zone
  std::size_t zone_size_ = 0, facets_size_ = 0, zone_vertices_size_ = 0;
  std::vector<Index> slots_;           // the slots of the new cells, by facet
  std::vector<Vertex> zone_vertices_;  // [0, zone_vertices_size_) are in use
  // By vertex: 1 to 255 while the vertex is in zone_vertices_ or one call lists it, else 0. Vertices from the 255th on
  // share 255.
  mutable std::vector<std::uint8_t> number_;
  mutable std::vector<Index> around_;  // scratch of neighbours_into()
  std::vector<Edge> edges_;            // the hash table of a large boundary
  bool vectors_;
  mutable std::uint32_t turn_ = 0;  // a counter that varies the facet with which a walk begins
  static constexpr std::size_t small = 64;
  alignas(64) std::array<Index, small * small> table_;  // by directed edge of a small boundary, in numbers of number_
};

}  // namespace tessera::flat3
