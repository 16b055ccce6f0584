// Saving and loading. An image may come from another kernel: the infinite vertex can be anywhere in its triangles.
#include <algorithm>

#include "src/kernel/flat_kernel_2_impl.h"

namespace tessera::flat2 {
namespace {

bool in_range(const KernelImage& image) {
  const std::size_t n = image.points.size(), corners = image.cells.vertices.size();
  if (n > vertices_max || image.local.size() != n || image.alive.size() != n) return false;
  if (image.cells.neighbors.size() != corners || corners % 3 != 0 || corners / 3 > triangles_max) return false;
  if (image.dimension < -1 || image.dimension > 2 || (image.dimension < 2) != (corners == 0)) return false;
  const auto vertex_there = [&](Vertex v) { return v == infinite_vertex || (v <= n && image.alive[v - 1]); };
  if (!std::all_of(image.cells.vertices.begin(), image.cells.vertices.end(), vertex_there)) return false;
  return std::all_of(image.cells.neighbors.begin(), image.cells.neighbors.end(), [&](std::uint32_t c) {
    return c & across_frozen ? (c & ~across_frozen) / 3 < image.frozen : c < corners / 3;
  });
}

// The edge of `to` that it has in common with `from` across edge i; 3 if there is none.
Word common_edge(const Triangle& from, Word i, const Triangle& to) {
  for (Word k = 0; k < 3; ++k) {
    if (to.v[next_of[k]] == from.v[before[i]] && to.v[before[k]] == from.v[next_of[i]]) return k;
  }
  return 3;
}

}  // namespace

KernelImage FlatKernel2::save() const {
  KernelImage image;
  const Vertex n = vertices();
  image.dimension = dimension_;
  image.frozen = frozen_;
  image.points.resize(n);
  image.local.resize(n);
  image.alive.resize(n);
  for (Vertex v = 1; v <= n; ++v) {
    image.local[v - 1] = is_local(v);
    if (!alive(v)) continue;
    image.points[v - 1] = point(v);
    image.alive[v - 1] = 1;
  }
  if (dimension_ == 2) image.cells = cells();
  return image;
}

bool FlatKernel2::load(const KernelImage& image) {
  if (!in_range(image)) return false;
  const std::size_t m = image.cells.vertices.size() / 3;
  Array<Triangle> loaded;
  loaded.resize(m);
  for (std::size_t c = 0; c < m; ++c) {
    Triangle& t = loaded[c];
    const auto vertex = &image.cells.vertices[3 * c];
    const auto neighbor = &image.cells.neighbors[3 * c];
    if (std::count(vertex, vertex + 3, infinite_vertex) > 1) return false;
    const Word first = vertex[0] == infinite_vertex ? 1 : 0;
    for (Word i = 0; i < 3; ++i) {
      t.v[i] = vertex[(i + first) % 3];
      t.n[i] = neighbor[(i + first) % 3];
    }
    t.state = State::plain;
  }
  for (std::size_t c = 0; c < m; ++c) {
    Triangle& t = loaded[c];
    for (Word i = 0; i < 3; ++i) {
      if (t.n[i] & frozen_bit) continue;
      const Word edge = common_edge(t, i, loaded[t.n[i]]);
      if (edge == 3) return false;
      t.n[i] = 4 * t.n[i] + edge;
    }
  }
  for (std::size_t c = 0; c < m; ++c) {
    for (Word i = 0; i < 3; ++i) {
      const Word across = loaded[c].n[i];
      if (!(across & frozen_bit) && loaded[across >> 2].n[across & 3] != 4 * c + i) return false;
    }
  }
  reset();
  const std::size_t n = image.points.size();
  mesh_.set_points(image.points, KeepPoints::copied);
  labels_.resize(n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    labels_[i + 1] = static_cast<std::uint8_t>((image.alive[i] ? alive_bit : 0) | (image.local[i] ? is_local_bit : 0));
  }
  for (Vertex v = 1; v <= n && dimension_ < 2; ++v) {
    if (alive(v)) span_more(v);
  }
  if (dimension_ != image.dimension) {
    reset();
    return false;
  }
  if (m == 0) return true;
  mesh_.triangles = std::move(loaded);
  mesh_.rebuild();
  frozen_ = image.frozen;
  return true;
}

}  // namespace tessera::flat2
