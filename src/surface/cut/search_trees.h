// Maximum flows within a region, by two search trees that are kept while flow changes.
//
// Incremental breadth-first search: A. V. Goldberg, S. Hed, H. Kaplan, R. E. Tarjan and R. F. Werneck, Maximum flows by
// incremental breadth-first search, ESA 2011. Trees grow from all cells with excess and from all with deficit, level by
// level; where they meet flow is pushed, and cells whose way to a root was saturated are adopted by a cell of the least
// level, which only rises. Time O(cells^2 arcs) at most, for graphs of cells next to nothing of it.
#pragma once

#include <cstdint>
#include <vector>

#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

class SearchTrees {
 public:
  // `graph` outlives this. Borders are left alone.
  explicit SearchTrees(CutGraph& graph) : graph_(graph) {}

  // Until no way leads from an excess to a deficit. Returns reached_from_excess().
  CellSet run();
  std::size_t bytes() const { return place_.capacity() * sizeof(Place); }

 private:
  enum class Side : std::uint8_t { source, sink };
  // Where a cell's parent is: across a facet, or one of these.
  static constexpr std::uint8_t root = 4, none = 5;
  struct Tree {
    std::vector<std::uint32_t> frontier;              // of the last level, not looked at yet
    std::vector<std::uint32_t> next;                  // of the level after it, while the tree grows
    std::vector<std::vector<std::uint32_t>> orphans;  // by level
    std::int32_t level = 1;                           // the last one
    std::int32_t allowed = 1;                         // that an orphan's parent is below
    std::size_t first = ~std::size_t{0}, last = 0;    // of the levels of orphans
  };

  void plant();
  template <Side side>
  void grow();
  template <Side side>
  void scan(std::uint32_t cell);
  void augment(Arc across);
  template <Side side>
  void push_to_root(std::uint32_t cell, std::uint32_t flow);
  template <Side side>
  std::int64_t room_to_root(std::uint32_t cell, std::int64_t most) const;
  template <Side side>
  void adopt_all();
  template <Side side>
  void adopt(std::uint32_t cell);
  template <Side side>
  void orphan(std::uint32_t cell);

  // Levels are positive on the source's side, negative on the sink's, 0 for cells of no tree.
  template <Side side>
  static std::int32_t level_of(std::int32_t level) {
    return side == Side::source ? level : -level;
  }
  // The residual capacity of the tree's arc between a cell and its parent across a facet: away from the root on the
  // source's side, to it on the sink's.
  template <Side side>
  std::uint32_t of_tree(Arc to_parent) const {
    return graph_.capacity[side == Side::source ? graph_.back[to_parent] : to_parent];
  }
  template <Side side>
  Tree& tree() {
    return side == Side::source ? source_ : sink_;
  }

  CutGraph& graph_;
  // Of a cell in a tree: asked for together.
  struct Place {
    std::int32_t level = 0;
    std::uint8_t parent = none;
  };
  std::vector<Place> place_;
  Tree source_, sink_;
};

// The cells that residual arcs lead to from those with excess: of all minimum cuts' source sets the smallest, if none
// of them has a deficit (docs/surfaces.md).
CellSet reached_from_excess(const CutGraph& graph);
// Whether one of them has.
bool any_deficit(const CutGraph& graph, const CellSet& cells);

}  // namespace tessera::cut
