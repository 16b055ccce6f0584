// Two kernels that are given the same calls: the flat one and CGAL's. Their answers must be the same.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/geometry/kernel/kernel.h"

namespace tessera::testing {

class KernelPair {
 public:
  // Of a cell, by its vertices in ascending order: kernels list them in different ones.
  using IsFinal = std::function<bool(const Vertex*)>;

  // `vectors`: whether the flat kernel may use vector instructions; in 2D it has none.
  explicit KernelPair(bool vectors, int dimension = 3);

  void build(std::span<const Point> points, KeepPoints keep);
  void insert(const Point& p, bool local, InsertMode mode);
  void remove(Vertex v);
  // What explore() finds and flags. Nothing while the points do not span everything.
  void compare_open(const IsFinal& is_final);
  // Freezes in the flat kernel alone, after comparing what is open. Nothing while the points do not span everything.
  void freeze(const IsFinal& is_final);
  // The cells whose circumsphere is inside the box.
  void freeze(const Box& box);
  void save_and_load();
  // Each kernel loads what the other saved. REQUIRES: no cell is frozen.
  void exchange();
  void compare_star(Vertex v);
  // edges_from(first). Nothing while the points do not span everything.
  void compare_edges(Vertex first);
  // Vertices and all cells, frozen ones and infinite ones too; and the flat kernel's structure: orientation, mutual
  // neighbours, the border of the frozen part.
  void compare_cells();

  const Kernel& flat() const { return *flat_; }
  // What is frozen, in the numbers of the flat kernel.
  const CellList& frozen() const { return frozen_; }
  std::size_t frozen_cells() const { return frozen_.vertices.size() / corners_; }
  // "", or the first difference.
  const std::string& wrong() const { return wrong_; }

 private:
  bool full() const { return flat_->dimension() == flat_->max_dimension(); }
  void fail(const std::string& what) {
    if (wrong_.empty()) wrong_ = what;
  }

  std::size_t corners_;  // of a cell
  std::unique_ptr<Kernel> flat_, cgal_;
  CellList frozen_;  // as freeze() gave them; a neighbour that is not frozen is open
  std::string wrong_;
};

}  // namespace tessera::testing
