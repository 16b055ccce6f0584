#include "src/surface/cut/search_trees.h"

#include <algorithm>
#include <utility>

namespace tessera::cut {

CellSet SearchTrees::run() {
  for (;;) {
    plant();
    while (!source_.frontier.empty() && !sink_.frontier.empty()) {
      if (source_.level <= sink_.level) {
        grow<Side::source>();
      } else {
        grow<Side::sink>();
      }
    }
    // The trees may have left out a cell, which would make the answer wrong. So the answer is checked.
    CellSet reached = reached_from_excess(graph_);
    if (!any_deficit(graph_, reached)) return reached;
  }
}

void SearchTrees::plant() {
  nodes_.assign(graph_.cells(), {});
  source_ = {};
  sink_ = {};
  for (std::uint32_t cell = 0; cell < graph_.cells(); ++cell) {
    if (graph_.excess[cell] == 0) continue;
    const bool gives = graph_.excess[cell] > 0;
    nodes_[cell].level = gives ? 1 : -1;
    nodes_[cell].parent = root;
    (gives ? source_ : sink_).frontier.push_back(cell);
  }
}

// Grows a tree by one level. Cells of the last level may have been scanned already when an orphan looks for a parent,
// so an orphan may stand one level further.
template <SearchTrees::Side side>
void SearchTrees::grow() {
  Tree& own = tree<side>();
  own.allowed = own.level + 1;
  for (std::size_t i = 0; i < own.frontier.size(); ++i) {
    const std::uint32_t cell = own.frontier[i];
    if (level_of<side>(nodes_[cell].level) == own.level) scan<side>(cell);
  }
  own.frontier.swap(own.next);
  own.next.clear();
  ++own.level;
}

template <SearchTrees::Side side>
void SearchTrees::scan(std::uint32_t cell) {
  Tree& own = tree<side>();
  for (std::uint32_t facet = 0; facet < 4; ++facet) {
    const Arc out = 4 * cell + facet, in = graph_.back[out];
    if (!is_inner(in)) continue;
    const std::uint32_t other = in >> 2u;
    while (graph_.capacity[side == Side::source ? out : in] > 0) {
      if (nodes_[other].level == 0) {
        nodes_[other].level = side == Side::source ? own.level + 1 : -own.level - 1;
        nodes_[other].parent = static_cast<std::uint8_t>(in & 3u);
        own.next.push_back(other);
        break;
      }
      if (level_of<side>(nodes_[other].level) > 0) break;
      augment(side == Side::source ? out : in);
      adopt_all<Side::source>();
      adopt_all<Side::sink>();
      if (level_of<side>(nodes_[cell].level) != own.level) return;
    }
  }
}

template <SearchTrees::Side side>
std::int64_t SearchTrees::room_to_root(std::uint32_t cell, std::int64_t most) const {
  while (nodes_[cell].parent != root) {
    const Arc up = 4 * cell + nodes_[cell].parent;
    most = std::min<std::int64_t>(most, of_tree<side>(up));
    cell = graph_.back[up] >> 2u;
  }
  return std::min(most, side == Side::source ? graph_.excess[cell] : -graph_.excess[cell]);
}

template <SearchTrees::Side side>
void SearchTrees::push_to_root(std::uint32_t cell, std::uint32_t flow) {
  while (nodes_[cell].parent != root) {
    const Arc up = 4 * cell + nodes_[cell].parent;
    const Arc along = side == Side::source ? graph_.back[up] : up;
    const std::uint32_t above = graph_.back[up] >> 2u;
    graph_.push(along, flow);
    if (graph_.capacity[along] == 0) orphan<side>(cell);
    cell = above;
  }
  if (graph_.excess[cell] == 0) orphan<side>(cell);
}

// Pushes flow along an arc from a cell of the source's tree to a cell of the sink's tree.
void SearchTrees::augment(Arc across) {
  const std::uint32_t from = across >> 2u, to = graph_.back[across] >> 2u;
  const std::int64_t room = room_to_root<Side::sink>(to, room_to_root<Side::source>(from, graph_.capacity[across]));
  const auto flow = static_cast<std::uint32_t>(room);
  graph_.push(across, flow);
  push_to_root<Side::source>(from, flow);
  push_to_root<Side::sink>(to, flow);
}

template <SearchTrees::Side side>
void SearchTrees::orphan(std::uint32_t cell) {
  auto& orphans = tree<side>().orphans;
  const auto level = static_cast<std::size_t>(level_of<side>(nodes_[cell].level));
  if (orphans.size() <= level) orphans.resize(level + 1);
  orphans[level].push_back(cell);
  Tree& own = tree<side>();
  own.first = std::min(own.first, level);
  own.last = std::max(own.last, level);
  nodes_[cell].parent = none;
}

// Adopts orphans from the least level on, so that a parent that is found has its own path to a root.
template <SearchTrees::Side side>
void SearchTrees::adopt_all() {
  Tree& own = tree<side>();
  auto& orphans = own.orphans;
  for (std::size_t level = own.first; level <= own.last; ++level) {
    while (!orphans[level].empty()) {
      const std::uint32_t cell = orphans[level].back();
      orphans[level].pop_back();
      adopt<side>(cell);
    }
  }
  own.first = ~std::size_t{0};
  own.last = 0;
}

template <SearchTrees::Side side>
void SearchTrees::adopt(std::uint32_t cell) {
  Tree& own = tree<side>();
  const std::int32_t level = level_of<side>(nodes_[cell].level);
  std::int32_t least = own.allowed;
  std::uint8_t parent = none;
  for (std::uint8_t facet = 0; facet < 4; ++facet) {
    const Arc to = 4 * cell + facet;
    if (!is_inner(graph_.back[to]) || of_tree<side>(to) == 0) continue;
    const std::int32_t other = level_of<side>(nodes_[graph_.back[to] >> 2u].level);
    if (other <= 0 || other >= least) continue;
    least = other;
    parent = facet;
    if (other == level - 1) break;
  }
  nodes_[cell].parent = parent;
  if (least == level - 1 && parent != none) return;
  // Its children are now too near to the root, or have lost their path.
  for (std::uint32_t facet = 0; facet < 4; ++facet) {
    const Arc across = graph_.back[4 * cell + facet];
    if (!is_inner(across)) continue;
    const std::uint32_t child = across >> 2u;
    if (level_of<side>(nodes_[child].level) > 0 && nodes_[child].parent == (across & 3u)) orphan<side>(child);
  }
  if (parent == none) {
    nodes_[cell].level = 0;
    return;
  }
  nodes_[cell].level = side == Side::source ? least + 1 : -least - 1;
  if (least + 1 == own.level) own.frontier.push_back(cell);
  if (least + 1 > own.level) own.next.push_back(cell);
}

CellSet reached_from_excess(const CutGraph& graph) {
  CellSet reached(graph.cells());
  std::vector<std::uint32_t> queue;
  for (std::uint32_t cell = 0; cell < graph.cells(); ++cell)
    if (graph.excess[cell] > 0 && reached.insert(cell)) queue.push_back(cell);
  while (!queue.empty()) {
    const std::uint32_t cell = queue.back();
    queue.pop_back();
    for (Arc arc = 4 * cell; arc < 4 * cell + 4; ++arc) {
      if (graph.capacity[arc] == 0 || !is_inner(graph.back[arc])) continue;
      const std::uint32_t other = graph.back[arc] >> 2u;
      if (reached.insert(other)) queue.push_back(other);
    }
  }
  return reached;
}

bool any_deficit(const CutGraph& graph, const CellSet& cells) {
  for (std::uint32_t cell = 0; cell < graph.cells(); ++cell)
    if (graph.excess[cell] < 0 && cells.contains(cell)) return true;
  return false;
}

}  // namespace tessera::cut
