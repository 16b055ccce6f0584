#include "src/result/volume/box_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tessera::volume {
namespace {

// Puts a zero between the bits of a number of 16 bits.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 8) & 0x00ff00ffu;
  bits = (bits | bits << 4) & 0x0f0f0f0fu;
  bits = (bits | bits << 2) & 0x33333333u;
  return (bits | bits << 1) & 0x55555555u;
}

// The place of a number between two others, with 16 bits.
std::uint32_t place(double value, double least, double most) {
  const double part = (value / 2 - least / 2) / (most / 2 - least / 2);
  return part > 0 ? static_cast<std::uint32_t>(std::min(part, 1.0) * 65535) : 0;
}

}  // namespace

BoxTree::BoxTree(std::span<const FlatBox> boxes) {
  if (boxes.empty()) return;
  FlatBox all = boxes[0];
  for (const FlatBox& box : boxes) all.add(box);
  std::vector<std::uint32_t> keys(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const double x = boxes[i].left / 2 + boxes[i].right / 2, y = boxes[i].low / 2 + boxes[i].high / 2;
    keys[i] = spread(place(x, all.left, all.right)) | spread(place(y, all.low, all.high)) << 1;
  }
  order_.resize(boxes.size());
  std::iota(order_.begin(), order_.end(), std::uint32_t{0});
  std::sort(order_.begin(), order_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  levels_.emplace_back(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) levels_[0][i] = boxes[order_[i]];
  while (levels_.back().size() > 1) {
    const auto& below = levels_.back();
    std::vector<FlatBox> level((below.size() + branches - 1) / branches);
    for (std::size_t i = 0; i < below.size(); ++i) {
      if (i % branches == 0)
        level[i / branches] = below[i];
      else
        level[i / branches].add(below[i]);
    }
    levels_.push_back(std::move(level));
  }
}

std::size_t BoxTree::bytes() const {
  std::size_t bytes = order_.size() * sizeof(std::uint32_t);
  for (const auto& level : levels_) bytes += level.size() * sizeof(FlatBox);
  return bytes;
}

}  // namespace tessera::volume
