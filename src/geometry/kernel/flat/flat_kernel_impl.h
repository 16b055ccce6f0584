// The flat kernels. A FlatKernel has a mesh and the labels of its vertices, and handles points that do not span space
// yet. flat_kernel_2.cc and flat_kernel_3.cc include this file and instantiate the class.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/check.h"
#include "src/base/stopped.h"
#include "src/geometry/kernel/brio.h"
#include "src/geometry/kernel/flat/flat_kernel.h"
#include "src/geometry/kernel/flat/mesh.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera::flat {

template <class Mesh>
class FlatKernel final : public Kernel {
 public:
  explicit FlatKernel(const FlatOptions& options) : options_(options), mesh_(options) { reset(); }

  int max_dimension() const override { return Mesh::dimension; }
  int dimension() const override { return mesh_.spanned(); }
  Vertex vertices() const override { return mesh_.points.size(); }
  Point point(Vertex v) const override { return mesh_.points[v]; }
  bool is_local(Vertex v) const override { return labels_[v] & is_local_bit; }
  bool alive(Vertex v) const override { return labels_[v] & alive_bit; }

  void build(std::span<const Point> points, KeepPoints keep, const std::stop_token& stop) override;
  Insertion insert(const Point& p, bool local, InsertMode mode, std::vector<Vertex>& around) override;
  void remove(Vertex v) override;
  void star(Vertex v, std::vector<Vertex>& cells) const override;
  void neighbours(Vertex v, std::vector<Vertex>& around) const override;
  void edges_from(Vertex first, const std::function<void(Vertex, Vertex)>& visit) const override;
  CellList cells() const override;
  CellRecords take_cells() override;
  std::vector<Vertex> explore(const std::function<bool(const Vertex*)>& is_final, CellList* all,
                              std::vector<std::uint8_t>* open) override;
  bool can_freeze() const override { return true; }
  FinalCells freeze(const std::function<bool(const Vertex*)>& is_final) override;
  std::uint64_t discard(const std::function<bool(const Vertex*)>& is_final, const TakeVertices& told) override;
  std::unique_ptr<Kernel> clone() const override;
  std::uint32_t rows() const override { return static_cast<std::uint32_t>(mesh_.cells.size()); }
  CellRecord row(std::uint32_t number) const override;
  KernelImage save() const override;
  bool load(const KernelImage& image) override;
  std::size_t memory() const override { return mesh_.memory() + labels_.capacity() + sizeof(*this); }

 private:
  using Cell = typename Mesh::Cell;
  static constexpr Index corners = Mesh::corners;
  static constexpr std::uint32_t inserts_a_look = 4096;  // between two looks at `stop`: some 0.01 s
  static constexpr std::uint8_t is_local_bit = 1, alive_bit = 2;

  bool full() const { return dimension() == max_dimension(); }
  void reset();
  Vertex add(const Point& p, bool local);
  // Computes what the living vertices span, until the first simplex is complete.
  void span();
  // Triangulates all living vertices. REQUIRES: full(), no cells.
  void triangulate(const std::stop_token& stop);
  Insertion insert_flat(const Point& p, bool local, std::vector<Vertex>& around);
  // Marks cells: as open those that explore() returns, as final those that were asked and are final. Returns the slots
  // of both.
  std::vector<Index> mark_open(const std::function<bool(const Vertex*)>& is_final);

  FlatOptions options_;
  Mesh mesh_;
  std::vector<std::uint8_t> labels_;  // by vertex; [0] is the infinite vertex: alive and not local
};

template <class Mesh>
void FlatKernel<Mesh>::reset() {
  mesh_.drop_cells();
  mesh_.points.copy({});
  labels_.assign(1, alive_bit);
}

template <class Mesh>
void FlatKernel<Mesh>::build(std::span<const Point> points, KeepPoints keep, const std::stop_token& stop) {
  reset();
  if (keep == KeepPoints::borrowed) {
    mesh_.points.borrow(points);
  } else {
    mesh_.points.copy(points);
  }
  labels_.resize(points.size() + 1, is_local_bit | alive_bit);
  span();
  if (full()) triangulate(stop);
}

template <class Mesh>
Vertex FlatKernel<Mesh>::add(const Point& p, bool local) {
  labels_.push_back(alive_bit | (local ? is_local_bit : 0));
  return mesh_.add(p);
}

template <class Mesh>
void FlatKernel<Mesh>::span() {
  for (Vertex v = 1; v <= vertices() && !full(); ++v) {
    if (alive(v)) mesh_.extend_simplex(v);
  }
}

template <class Mesh>
void FlatKernel<Mesh>::triangulate(const std::stop_token& stop) {
  mesh_.start();
  StopCheck check_stop(stop, inserts_a_look);
  for_each_in_brio_order<Mesh::brio_bits>(vertices(), [&](std::size_t i) {
    const Vertex v = static_cast<Vertex>(i + 1);
    if (alive(v) && !mesh_.in_simplex(v)) mesh_.insert(v);
    check_stop.step();
  });
  mesh_.compact();
}

template <class Mesh>
Insertion FlatKernel<Mesh>::insert_flat(const Point& p, bool local, std::vector<Vertex>& around) {
  for (Vertex v = 1; v <= vertices(); ++v) {
    if (!alive(v)) continue;
    if (same_place<Mesh::dimension>(point(v), p)) {
      around.clear();
      return {v, false};
    }
    around.push_back(v);
  }
  const Vertex v = add(p, local);
  mesh_.extend_simplex(v);
  if (full()) triangulate({});
  return {v, true};
}

template <class Mesh>
Insertion FlatKernel<Mesh>::insert(const Point& p, bool local, InsertMode mode, std::vector<Vertex>& around) {
  around.clear();
  if (!full()) return insert_flat(p, local, around);
  const Located found = mesh_.locate(p);
  if (found.same != 0) return {found.same, false};
  mesh_.find_zone(p, found.cell);
  // Every vertex of a conflict zone lies on the zone's boundary. So these are the neighbours of the point once it is
  // inserted.
  mesh_.zone_into(around);
  if (mode == InsertMode::if_local_neighbour &&
      std::none_of(around.begin(), around.end(), [&](Vertex v) { return is_local(v); })) {
    mesh_.leave();
    return {0, false};
  }
  const Vertex v = add(p, local);
  mesh_.fill(v);
  return {v, true};
}

template <class Mesh>
void FlatKernel<Mesh>::remove(Vertex v) {
  check(alive(v), "a vertex is removed once");
  const bool still_full = full() && mesh_.remove(v);
  labels_[v] = static_cast<std::uint8_t>(labels_[v] & ~alive_bit);
  if (still_full) return;
  mesh_.drop_cells();
  span();
}

template <class Mesh>
std::unique_ptr<Kernel> FlatKernel<Mesh>::clone() const {
  auto copy = std::make_unique<FlatKernel>(options_);
  copy->mesh_.copy(mesh_);
  copy->labels_ = labels_;
  return copy;
}

template <class Mesh>
CellRecord FlatKernel<Mesh>::row(std::uint32_t number) const {
  CellRecord out{};
  const Cell& c = mesh_.cells[number];
  std::copy(c.v, c.v + corners, out.vertices);
  std::copy(c.n, c.n + corners, out.neighbors);
  if (c.dead()) out.vertices[0] = CellRecord::gap;
  return out;
}

template <class Mesh>
void FlatKernel<Mesh>::star(Vertex v, std::vector<Vertex>& cells) const {
  std::vector<Index> slots;
  mesh_.around(v, slots);
  cells.clear();
  for (const Index slot : slots) cells.insert(cells.end(), mesh_.cells[slot].v, mesh_.cells[slot].v + corners);
}

template <class Mesh>
void FlatKernel<Mesh>::neighbours(Vertex v, std::vector<Vertex>& around) const {
  around.clear();
  if (!full()) {
    for (Vertex w = 1; w <= vertices(); ++w) {
      if (w != v && alive(w)) around.push_back(w);
    }
    return;
  }
  mesh_.neighbours_into(v, around);
}

}  // namespace tessera::flat
