#include "src/kernel/flat_kernel_3.h"

#include <algorithm>

#include "src/base/check.h"
#include "src/kernel/brio.h"
#include "src/kernel/exact_predicates.h"
#include "src/kernel/flat_kernel_3_impl.h"

namespace tessera {
namespace flat {

void FlatKernel3::reset() {
  mesh_.clear();
  labels_.assign(1, alive_bit);
  dimension_ = -1;
  frozen_cells_ = 0;
}

void FlatKernel3::build(std::span<const Point> points, KeepPoints keep) {
  if (points.size() > vertices_max) throw KernelFull();
  reset();
  if (keep == KeepPoints::borrowed) {
    mesh_.points.borrow(points);
  } else {
    mesh_.points.copy(points);
  }
  labels_.resize(points.size() + 1, is_local_bit | alive_bit);
  for (Vertex v = 1; v <= points.size() && dimension_ < 3; ++v) span_more(v);
  if (dimension_ == 3) triangulate();
}

void FlatKernel3::span_more(Vertex v) {
  const Point& p = mesh_.points[v];
  const auto corner = [&](int i) -> const Point& { return mesh_.points[simplex_[static_cast<std::size_t>(i)]]; };
  const bool more = dimension_ == -1  ? true
                    : dimension_ == 0 ? corner(0) != p
                    : dimension_ == 1 ? !collinear_3(corner(0), corner(1), p)
                                      : exact::orient3(corner(0), corner(1), corner(2), p) != 0;
  if (more) simplex_[static_cast<std::size_t>(++dimension_)] = v;
}

void FlatKernel3::triangulate() {
  mesh_.start(simplex_);
  for_each_in_brio_order(vertices(), [&](std::size_t i) {
    const Vertex v = static_cast<Vertex>(i + 1);
    if (alive(v) && std::find(simplex_.begin(), simplex_.end(), v) == simplex_.end()) mesh_.insert(v);
  });
  mesh_.compact();
}

void FlatKernel3::flatten() {
  mesh_.drop_cells();
  dimension_ = -1;
  for (Vertex v = 1; v <= vertices(); ++v) {
    if (alive(v)) span_more(v);
  }
}

Insertion FlatKernel3::insert_flat(const Point& p, bool local, std::vector<Vertex>& around) {
  for (Vertex v = 1; v <= vertices(); ++v) {
    if (!alive(v)) continue;
    if (mesh_.points[v] == p) {
      around.clear();
      return {v, false};
    }
    around.push_back(v);
  }
  const Vertex v = mesh_.points.add(p);
  labels_.push_back(alive_bit | (local ? is_local_bit : 0));
  span_more(v);
  if (dimension_ == 3) triangulate();
  return {v, true};
}

Insertion FlatKernel3::insert(const Point& p, bool local, InsertMode mode, std::vector<Vertex>& around) {
  around.clear();
  if (dimension_ < 3) return insert_flat(p, local, around);
  const Located found = mesh_.locate(p);
  if (found.same != 0) return {found.same, false};
  mesh_.find_zone(p, found.cell);
  zone_into(around);
  if (mode == InsertMode::if_local_neighbour &&
      std::none_of(around.begin(), around.end(), [&](Vertex v) { return is_local(v); })) {
    mesh_.leave();
    return {0, false};
  }
  const Vertex v = mesh_.points.add(p);
  labels_.push_back(alive_bit | (local ? is_local_bit : 0));
  mesh_.fill(v);
  return {v, true};
}

// Every vertex of a conflict zone is on its boundary, so these are the neighbours of the point once it is inserted.
void FlatKernel3::zone_into(std::vector<Vertex>& around) const {
  const auto zone = mesh_.zone_vertices();
  around.assign(zone.begin(), zone.end());
  std::erase(around, infinite_vertex);
}

void FlatKernel3::remove(Vertex v) {
  check(alive(v), "a vertex is removed once");
  const bool full = dimension_ == 3 && mesh_.remove(v);
  labels_[v] = static_cast<std::uint8_t>(labels_[v] & ~alive_bit);
  if (!full) flatten();
}

void FlatKernel3::star(Vertex v, std::vector<Vertex>& cells) const {
  std::vector<Word> slots;
  mesh_.around(v, slots);
  cells.clear();
  for (const Word slot : slots) cells.insert(cells.end(), mesh_.cells[slot].v, mesh_.cells[slot].v + 4);
}

void FlatKernel3::neighbours(Vertex v, std::vector<Vertex>& around) const {
  around.clear();
  if (dimension_ < 3) {
    for (Vertex w = 1; w <= vertices(); ++w) {
      if (w != v && alive(w)) around.push_back(w);
    }
    return;
  }
  star(v, around);
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  std::erase_if(around, [&](Vertex w) { return w == v || w == infinite_vertex; });
}

std::size_t FlatKernel3::memory() const { return mesh_.memory() + labels_.capacity() + sizeof(*this) - sizeof(Mesh); }

}  // namespace flat

std::unique_ptr<Kernel> make_flat_kernel_3() { return std::make_unique<flat::FlatKernel3>(true); }
std::unique_ptr<Kernel> make_plain_flat_kernel_3() { return std::make_unique<flat::FlatKernel3>(false); }

}  // namespace tessera
