// Maximum flows within a region, by two search trees that are kept while the flow changes.
//
// Incremental breadth-first search: A. V. Goldberg, S. Hed, H. Kaplan, R. E. Tarjan and R. F. Werneck, Maximum flows by
// incremental breadth-first search, ESA 2011. Trees grow from all cells with excess and from all cells with deficit,
// level by level. Where they meet, flow is pushed. Cells whose path to a root was saturated are adopted by a cell of
// the least level; levels only rise. The time is at most O(cells^2 arcs), and far less for graphs of cells.
#pragma once

#include <cstdint>
#include <vector>

#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

class SearchTrees {
 public:
  // `graph` outlives this object. Borders are left alone.
  explicit SearchTrees(CutGraph& graph) : graph_(graph) {}

  // Moves flow until no path leads from an excess to a deficit. Returns reached_from_excess().
  CellSet run();
  std::size_t bytes() const { return nodes_.capacity() * sizeof(TreeNode); }

 private:
  enum class Side : std::uint8_t { source, sink };
  // Across which facet a cell's parent is, or one of these.
  static constexpr std::uint8_t root = 4, none = 5;
  struct Tree {
    std::vector<std::uint32_t> frontier;              // of the last level, not looked at yet
    std::vector<std::uint32_t> next;                  // of the next level, while the tree grows
    std::vector<std::vector<std::uint32_t>> orphans;  // by level
    std::int32_t level = 1;                           // the last level
    std::int32_t allowed = 1;                         // an orphan's parent must have a lower level
    std::size_t first = ~std::size_t{0}, last = 0;    // range of levels that have orphans
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

  // Levels are positive on the source's side, negative on the sink's side, and 0 for cells in no tree.
  template <Side side>
  static std::int32_t level_of(std::int32_t level) {
    return side == Side::source ? level : -level;
  }
  // Returns the residual capacity of the tree's arc between a cell and its parent across a facet. The arc leads away
  // from the root on the source's side, and to the root on the sink's side.
  template <Side side>
  std::uint32_t of_tree(Arc to_parent) const {
    return graph_.capacity[side == Side::source ? graph_.back[to_parent] : to_parent];
  }
  template <Side side>
  Tree& tree() {
    return side == Side::source ? source_ : sink_;
  }

  CutGraph& graph_;
  // What is known of a cell in a tree. Level and parent stand together, because they are read together.
  struct TreeNode {
    std::int32_t level = 0;
    std::uint8_t parent = none;
  };
  std::vector<TreeNode> nodes_;
  Tree source_, sink_;
};

// Returns the cells to which residual arcs lead from cells with excess. If none of them has a deficit, it is the
// smallest source set of all minimum cuts (docs/surfaces.md).
CellSet reached_from_excess(const CutGraph& graph);
// Whether one of the cells has a deficit.
bool any_deficit(const CutGraph& graph, const CellSet& cells);

}  // namespace tessera::cut
