#include "src/result/region/unit_tree.h"

#include <algorithm>
#include <numeric>

namespace tessera {

double squared_distance(const Bounds& a, const Bounds& b) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double beside = std::max({a.lo[axis] - b.hi[axis], b.lo[axis] - a.hi[axis], 0.0});
    sum += beside * beside;
  }
  return sum;
}

bool boxes_meet(const Bounds& a, const Bounds& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (a.hi[axis] < b.lo[axis] || a.lo[axis] > b.hi[axis]) return false;
  return true;
}

UnitTree::UnitTree(std::vector<Bounds> boxes) : leaf_(boxes.size()) {
  if (boxes.empty()) return;
  std::vector<std::uint32_t> units(boxes.size());
  std::iota(units.begin(), units.end(), 0u);
  nodes_.reserve(2 * boxes.size());
  build(units, 0, units.size(), boxes);
}

std::uint32_t UnitTree::build(std::vector<std::uint32_t>& units, std::size_t begin, std::size_t end,
                              const std::vector<Bounds>& boxes) {
  const auto at = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  for (std::size_t i = begin; i < end; ++i) node.box.add(boxes[units[i]]);
  if (end - begin == 1) {
    node.left = node.right = units[begin];
    leaf_[units[begin]] = at;
    nodes_.push_back(node);
    return at;
  }
  nodes_.push_back(node);
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (node.box.hi[i] - node.box.lo[i] > node.box.hi[axis] - node.box.lo[axis]) axis = i;
  const std::size_t middle = begin + (end - begin) / 2;
  const auto from = units.begin();
  std::nth_element(from + static_cast<std::ptrdiff_t>(begin), from + static_cast<std::ptrdiff_t>(middle),
                   from + static_cast<std::ptrdiff_t>(end), [&](std::uint32_t a, std::uint32_t b) {
                     return boxes[a].lo[axis] / 2 + boxes[a].hi[axis] / 2 <
                            boxes[b].lo[axis] / 2 + boxes[b].hi[axis] / 2;
                   });
  const std::uint32_t left = build(units, begin, middle, boxes), right = build(units, middle, end, boxes);
  nodes_[at].left = left;
  nodes_[at].right = right;
  nodes_[left].parent = nodes_[right].parent = at;
  return at;
}

void UnitTree::begin(const Bounds& region) {
  for (std::size_t i = nodes_.size(); i-- > 0;) {  // children come after their parents
    Node& node = nodes_[i];
    node.unread = node.is_leaf() ? 1 : nodes_[node.left].unread + nodes_[node.right].unread;
    node.distance = squared_distance(node.box, region);
  }
}

void UnitTree::take(std::size_t unit) {
  if (!is_unread(unit)) return;
  for (std::uint32_t at = leaf_[unit];; at = nodes_[at].parent) {
    --nodes_[at].unread;
    if (at == 0) return;
  }
}

}  // namespace tessera
