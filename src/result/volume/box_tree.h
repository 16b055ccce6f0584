// Finds the boxes that meet a box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/result/volume/facet.h"

namespace tessera::volume {

// A packed tree: boxes are sorted along a Z-curve, and groups of them have a common box. There are fewer than 2^32.
class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(std::span<const FlatBox> boxes);

  // Calls visit(number) for each box that meets `box`, in an order that depends on the boxes alone.
  template <class Visit>
  void for_each_near(const FlatBox& box, const Visit& visit) const {
    if (!levels_.empty()) descend(levels_.size() - 1, 0, box, visit);
  }
  std::size_t bytes() const;

 private:
  static constexpr std::size_t branches = 8;

  template <class Visit>
  void descend(std::size_t level, std::size_t at, const FlatBox& box, const Visit& visit) const {
    if (!levels_[level][at].meets(box)) return;
    if (level == 0) {
      visit(order_[at]);
      return;
    }
    const std::size_t all = levels_[level - 1].size();
    for (std::size_t i = at * branches; i < all && i < (at + 1) * branches; ++i) descend(level - 1, i, box, visit);
  }

  std::vector<std::uint32_t> order_;          // numbers of boxes, near ones together
  std::vector<std::vector<FlatBox>> levels_;  // the boxes in this order, those of their groups, ... that of all
};

}  // namespace tessera::volume
