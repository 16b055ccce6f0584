// Saving and loading. An image may come from another kernel: the infinite vertex can be anywhere in its cells.
#include <algorithm>

#include "src/kernel/flat_kernel_3_impl.h"

namespace tessera::flat {
namespace {

bool in_range(const KernelImage& image) {
  const std::size_t n = image.points.size(), corners = image.cells.vertices.size();
  if (n > vertices_max || image.local.size() != n || image.alive.size() != n) return false;
  if (image.cells.neighbors.size() != corners || corners % 4 != 0 || corners / 4 > cells_max) return false;
  if (image.dimension < -1 || image.dimension > 3 || (image.dimension < 3) != (corners == 0)) return false;
  const auto vertex_there = [&](Vertex v) { return v == infinite_vertex || (v <= n && image.alive[v - 1]); };
  if (!std::all_of(image.cells.vertices.begin(), image.cells.vertices.end(), vertex_there)) return false;
  return std::all_of(image.cells.neighbors.begin(), image.cells.neighbors.end(), [&](std::uint32_t c) {
    return c & across_frozen ? (c & ~across_frozen) / 4 < image.frozen : c < corners / 4;
  });
}

// Moves the infinite vertex to the end by an even permutation. False if it is there twice.
bool put_infinite_last(Cell& cell) {
  const auto count = std::count(cell.v, cell.v + 4, infinite_vertex);
  if (count > 1) return false;
  if (count == 0 || cell.infinite()) return true;
  const auto i = std::find(cell.v, cell.v + 4, infinite_vertex) - cell.v;
  const auto a = (i + 1) % 3, b = (i + 2) % 3;
  for (Word* words : {cell.v, cell.n}) {
    std::swap(words[i], words[3]);
    std::swap(words[a], words[b]);
  }
  return true;
}

// The facet of `to` that it has in common with `from` across facet i; 4 if there is none.
Word common_facet(const Cell& from, Word i, const Cell& to) {
  Word found = 4;
  int shared = 0;
  for (Word k = 0; k < 4; ++k) {
    bool is_shared = false;
    for (Word j = 0; j < 4; ++j) is_shared |= j != i && from.v[j] == to.v[k];
    shared += is_shared;
    if (!is_shared) found = k;
  }
  return shared == 3 ? found : 4;
}

}  // namespace

KernelImage FlatKernel3::save() const {
  KernelImage image;
  const Vertex n = vertices();
  image.dimension = dimension_;
  image.frozen = frozen_cells_;
  image.points.resize(n);
  image.local.resize(n);
  image.alive.resize(n);
  for (Vertex v = 1; v <= n; ++v) {
    image.local[v - 1] = is_local(v);
    if (!alive(v)) continue;
    image.points[v - 1] = point(v);
    image.alive[v - 1] = 1;
  }
  if (dimension_ == 3) image.cells = cells();
  return image;
}

bool FlatKernel3::load(const KernelImage& image) {
  if (!in_range(image)) return false;
  const std::size_t m = image.cells.vertices.size() / 4;
  Array<Cell> loaded;
  loaded.resize(m);
  for (std::size_t c = 0; c < m; ++c) {
    std::copy_n(&image.cells.vertices[4 * c], 4, loaded[c].v);
    std::copy_n(&image.cells.neighbors[4 * c], 4, loaded[c].n);
    if (!put_infinite_last(loaded[c])) return false;
  }
  for (std::size_t c = 0; c < m; ++c) {
    Cell& cell = loaded[c];
    for (Word i = 0; i < 4; ++i) {
      if (cell.n[i] & frozen_bit) continue;
      const Word facet = common_facet(cell, i, loaded[cell.n[i]]);
      if (facet == 4) return false;
      cell.n[i] = 4 * cell.n[i] + facet;
    }
  }
  for (std::size_t c = 0; c < m; ++c) {
    for (Word i = 0; i < 4; ++i) {
      const Word across = loaded[c].n[i];
      if (!(across & frozen_bit) && loaded[across >> 2].n[across & 3] != 4 * c + i) return false;
    }
  }
  reset();
  const std::size_t n = image.points.size();
  mesh_.points.copy(image.points);
  labels_.resize(n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    labels_[i + 1] = static_cast<std::uint8_t>((image.alive[i] ? alive_bit : 0) | (image.local[i] ? is_local_bit : 0));
  }
  for (Vertex v = 1; v <= n && dimension_ < 3; ++v) {
    if (alive(v)) span_more(v);
  }
  if (dimension_ != image.dimension) {
    reset();
    return false;
  }
  if (m == 0) return true;
  mesh_.simplex = simplex_;
  mesh_.cells = std::move(loaded);
  frozen_cells_ = image.frozen;
  mesh_.set_frozen(frozen_cells_ > 0);
  mesh_.rebuild();
  return true;
}

}  // namespace tessera::flat
