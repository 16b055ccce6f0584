// Sets that become one (union-find), with path halving and union by size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tessera {

class DisjointSets {
 public:
  // REQUIRES: size < 2^32.
  explicit DisjointSets(std::size_t size = 0) { grow(size); }
  std::size_t size() const { return parent_.size(); }
  // Adds sets of one element each.
  void grow(std::size_t size) {
    for (std::size_t i = parent_.size(); i < size; ++i) {
      parent_.push_back(static_cast<std::uint32_t>(i));
      size_.push_back(1);
    }
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  // Joins two sets, and returns the root of the new one. REQUIRES: a and b are roots.
  std::uint32_t join(std::uint32_t a, std::uint32_t b) {
    if (a == b) return a;
    if (size_[a] < size_[b]) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
    return a;
  }

 private:
  std::vector<std::uint32_t> parent_, size_;
};

}  // namespace tessera
