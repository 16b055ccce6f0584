// The units that are not read yet, as a tree of boxes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/point.h"

namespace tessera {

class UnitTree {
 public:
  // `boxes` are closed and finite, one a unit. In 2D z is 0.
  explicit UnitTree(std::vector<Bounds> boxes);

  // Begins a question: all units are unread. Distances are measured to `region`, a finite box.
  void begin(const Bounds& region);
  void take(std::size_t unit);  // marks the unit as read
  bool is_unread(std::size_t unit) const { return nodes_[leaf_[unit]].unread > 0; }
  bool all_read() const { return nodes_.empty() || nodes_[0].unread == 0; }
  // Squared and rounded. Used only for choices that do not change the result.
  double distance(std::size_t unit) const { return nodes_[leaf_[unit]].distance; }

  // Returns the unread unit that `meets` accepts and that is nearest to the region; of equally near units, the first.
  // When `meets(box)` is true for a box, it must be true for every box that contains it.
  template <class Meets>
  std::optional<std::size_t> nearest(const Meets& meets) const {
    std::optional<std::size_t> best;
    if (!nodes_.empty()) search(0, meets, best);
    return best;
  }

 private:
  struct Node {
    Bounds box;
    std::uint32_t parent = 0, left = 0, right = 0;  // left == right: a leaf, with this unit
    std::uint32_t unread = 0;
    double distance = 0;
    bool is_leaf() const { return left == right; }
  };

  std::uint32_t build(std::vector<std::uint32_t>& units, std::size_t begin, std::size_t end,
                      const std::vector<Bounds>& boxes);

  template <class Meets>
  void search(std::uint32_t at, const Meets& meets, std::optional<std::size_t>& best) const {
    const Node& node = nodes_[at];
    if (node.unread == 0 || (best && node.distance > distance(*best)) || !meets(node.box)) return;
    if (node.is_leaf()) {
      if (!best || node.distance < distance(*best) || node.left < *best) best = node.left;
      return;
    }
    const bool left_first = nodes_[node.left].distance <= nodes_[node.right].distance;
    search(left_first ? node.left : node.right, meets, best);
    search(left_first ? node.right : node.left, meets, best);
  }

  std::vector<Node> nodes_;  // the root first
  std::vector<std::uint32_t> leaf_;
};

// The squared distance between two closed boxes, rounded.
double squared_distance(const Bounds& a, const Bounds& b);
bool boxes_meet(const Bounds& a, const Bounds& b);

}  // namespace tessera
