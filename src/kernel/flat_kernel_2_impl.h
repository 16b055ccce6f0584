// The flat kernel in 2D: a mesh, the labels of its vertices, and what there is while the points are collinear.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/kernel/flat_mesh_2.h"
#include "src/kernel/kernel.h"

namespace tessera::flat2 {

class FlatKernel2 final : public Kernel {
 public:
  FlatKernel2() { reset(); }

  int max_dimension() const override { return 2; }
  int dimension() const override { return dimension_; }
  Vertex vertices() const override { return mesh_.vertices(); }
  Point point(Vertex v) const override { return mesh_.point(v); }
  bool is_local(Vertex v) const override { return labels_[v] & is_local_bit; }
  bool alive(Vertex v) const override { return labels_[v] & alive_bit; }

  void build(std::span<const Point> points, KeepPoints keep) override;
  Insertion insert(const Point& p, bool local, InsertMode mode, std::vector<Vertex>& around) override;
  void remove(Vertex v) override;
  void star(Vertex v, std::vector<Vertex>& cells) const override;
  void neighbours(Vertex v, std::vector<Vertex>& around) const override;
  CellList cells() const override;
  std::vector<Vertex> explore(const std::function<bool(const Vertex*)>& settled, CellList* all,
                              std::vector<std::uint8_t>* open) override;
  bool can_freeze() const override { return true; }
  FrozenCells freeze(const std::function<bool(const Vertex*)>& settled) override;
  KernelImage save() const override;
  bool load(const KernelImage& image) override;
  std::size_t memory() const override;

 private:
  static constexpr std::uint8_t is_local_bit = 1, alive_bit = 2;

  void reset();
  // While dimension() < 2: takes v into the simplex that spans the points so far, if it spans more with it.
  void span_more(Vertex v);
  // The triangulation of all vertices alive. REQUIRES: the simplex is complete.
  void triangulate();
  void flatten();  // once the vertices are collinear again
  Insertion insert_flat(const Point& p, bool local, std::vector<Vertex>& around);
  // Marks the triangles that explore() returns as open and those that were asked and are settled as settled; returns
  // both.
  std::vector<Word> mark_open(const std::function<bool(const Vertex*)>& settled);
  // For each slot, the triangles before it that `counts`.
  template <class Counts>
  std::vector<Word> ranks(Counts&& counts) const;

  Mesh mesh_;
  std::vector<std::uint8_t> labels_;  // by vertex; [0] is the infinite vertex: alive, not local
  int dimension_ = -1;
  std::array<Vertex, 3> simplex_{};  // dimension_ + 1 vertices that are affinely independent
  std::uint32_t frozen_ = 0;         // triangles that were frozen
};

}  // namespace tessera::flat2
