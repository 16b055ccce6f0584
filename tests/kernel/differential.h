// Two kernels that are given the same calls: the flat one and CGAL's. Their answers must be the same.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/kernel/kernel.h"

namespace tessera::testing {

class KernelPair {
 public:
  // `vectors`: whether the flat kernel may use vector instructions.
  explicit KernelPair(bool vectors);

  void build(std::span<const Point> points, KeepPoints keep);
  void insert(const Point& p, bool local, InsertMode mode);
  void remove(Vertex v);
  // Freezes the cells whose circumsphere is inside the box, in the flat kernel alone, after comparing what is open.
  // Nothing while the points span no volume.
  void freeze(const Box& box);
  void save_and_load();
  void compare_star(Vertex v);
  // All cells, frozen ones and infinite ones too; and the flat kernel's structure: orientation, mutual neighbours, the
  // border of the frozen part.
  void compare_cells();

  const Kernel& flat() const { return *flat_; }
  std::size_t frozen_cells() const { return frozen_.vertices.size() / 4; }
  // "", or the first difference.
  const std::string& wrong() const { return wrong_; }

 private:
  void fail(const std::string& what) {
    if (wrong_.empty()) wrong_ = what;
  }

  std::unique_ptr<Kernel> flat_, cgal_;
  FrozenCells frozen_;
  std::string wrong_;
};

}  // namespace tessera::testing
