#include "src/kernel/flat_mesh_2.h"

#include <algorithm>
#include <cmath>

#include "src/base/check.h"
#include "src/kernel/exact_predicates.h"

namespace tessera::flat2 {

void Mesh::set_points(std::span<const Point> points, KeepPoints keep) {
  if (points.size() > vertices_max) throw KernelFull();
  own_.clear();
  vertices_ = static_cast<Vertex>(points.size());
  borrowed_ = keep == KeepPoints::borrowed;
  if (borrowed_) {
    points_ = points.data();
    return;
  }
  own_.resize(points.size());
  std::copy(points.begin(), points.end(), own_.data());
  points_ = own_.data();
}

Vertex Mesh::add(const Point& p) {
  if (vertices_ >= vertices_max) throw KernelFull();
  const Point copy = p;  // p may be one of ours
  if (borrowed_) set_points({points_, vertices_}, KeepPoints::copied);
  own_.push_back(copy);
  points_ = own_.data();
  return ++vertices_;
}

void Mesh::drop_triangles() {
  triangles.clear();
  free_.clear();
  incident_.clear();
  indexed_ = false;
  last_ = 0;
}

inline void Mesh::link(Word triangle, Word edge, Word across) {
  triangles[triangle].n[edge] = across;
  if (!(across & frozen_bit)) triangles[across >> 2].n[across & 3] = 4 * triangle + edge;
}

void Mesh::start(std::array<Vertex, 3> v) {
  const int turn = exact::orient2(point(v[0]), point(v[1]), point(v[2]));
  check(turn != 0 && !started(), "a triangulation starts with three points that are not collinear");
  if (turn < 0) std::swap(v[0], v[1]);
  triangles.reserve(2 * std::size_t{vertices_} + 64);
  triangles.resize(4);
  triangles[0] = {{v[0], v[1], v[2]}, State::plain, {}};
  for (Word i = 0; i < 3; ++i) {  // hull edge i, seen from outside, then the infinite vertex
    triangles[1 + i] = {{v[before[i]], v[next_of[i]], infinite_vertex}, State::plain, {}};
  }
  for (Word i = 0; i < 3; ++i) {
    link(0, i, 4 * (1 + i) + 2);
    link(1 + i, 0, 4 * (1 + before[i]) + 1);  // both have the edge from v[next_of[i]] to the infinite vertex
  }
  last_ = 0;
}

bool Mesh::conflicts_with_hull(const Point& p, const Triangle& t) const {
  const Word i = t.v[1] == infinite_vertex ? 1 : 2;
  const Point &a = point(t.v[next_of[i]]), &b = point(t.v[before[i]]);
  if (const int side = exact::orient2(a, b, p); side != 0) return side > 0;
  // On the line of a hull edge: in conflict strictly between its ends.
  const bool by_x = a.x != b.x;
  const double from = by_x ? a.x : a.y, to = by_x ? b.x : b.y, at = by_x ? p.x : p.y;
  return (from < at && at < to) || (to < at && at < from);
}

bool Mesh::conflicts(const Point& p, const Triangle& t) const {
  if (t.infinite()) [[unlikely]]
    return conflicts_with_hull(p, t);
  return exact::incircle_perturbed(point(t.v[0]), point(t.v[1]), point(t.v[2]), p) > 0;
}

// In 2D a conflict zone has no vertex inside, so its triangles and their common edges are a tree: none is met twice,
// and going through it depth first, counterclockwise, gives the boundary in order. Both edges of a triangle are asked
// before either answer is used: answers cannot be foreseen, and so two are waited for at once.
void Mesh::find_zone(const Point& query, Word start) {
  const Point p = query;
  const Triangle* const all = triangles.data();
  const Point* const points = points_;
  if (near_.size() < 64) near_.resize(64), pending_.resize(64), boundary_.resize(64), zone_.resize(64);
  Near* near = near_.data();
  Pending* pending = pending_.data();
  Word near_size = 0;
  std::size_t size = 0, zone_size = 0, boundary_size = 0;

  const auto add_near = [&](Vertex v) {
    Near& c = near[near_size++];
    c.v = v;
    if (v == infinite_vertex) [[unlikely]]
      return;
    const double x = points[v - 1].x - p.x, y = points[v - 1].y - p.y;
    c.x = x, c.y = y, c.lift = x * x + y * y;
  };
  // Puts the edge from a to b on the stack, with the answer whether the triangle across it is in conflict.
  const auto ask = [&](Word across, Word a_index, Word b_index) __attribute__((always_inline)) {
    Pending& edge = pending[size++];
    edge.across = across, edge.a = a_index, edge.b = b_index, edge.c = near_size;
    if (across & frozen_bit) [[unlikely]] {
      edge.in_conflict = false;
      return;
    }
    const Triangle& t = all[across >> 2];  // (c, b, a)
    const Near &a = near[a_index], &b = near[b_index], &c = near[near_size];
    add_near(t.v[across & 3]);
    if (c.v == infinite_vertex || a.v == infinite_vertex || b.v == infinite_vertex) [[unlikely]] {
      edge.in_conflict = conflicts_with_hull(p, t);
      return;
    }
    // As exact::filter::incircle, with the largest lift in place of the product of the largest x and y.
    const double det =
        a.lift * (c.x * b.y - b.x * c.y) + c.lift * (b.x * a.y - a.x * b.y) + b.lift * (a.x * c.y - c.x * a.y);
    const double lift = std::max(std::max(a.lift, b.lift), c.lift);
    const double error = 70 * exact::filter::u * (lift * lift) + exact::filter::underflow;
    if (std::abs(det) > error && lift < exact::filter::lift_max) [[likely]] {
      edge.in_conflict = det > 0;
    } else {
      edge.in_conflict = exact::incircle_perturbed(point(t.v[0]), point(t.v[1]), point(t.v[2]), p) > 0;
    }
  };

  zone_[zone_size++] = start;
  const Triangle& first = all[start];
  for (const Vertex v : first.v) add_near(v);
  ask(first.n[1], 2, 0);
  ask(first.n[0], 1, 2);
  ask(first.n[2], 0, 1);
  while (size > 0) {
    const Pending& edge = pending[--size];
    const Word across = edge.across, a = edge.a, b = edge.b, c = edge.c;  // one by one: they were just stored like that
    if (!edge.in_conflict) {
      boundary_[boundary_size++] = {across, near[a].v};
      continue;
    }
    const Word slot = across >> 2, i = across & 3;
    zone_[zone_size++] = slot;
    if (near_size + 4 > near_.size()) [[unlikely]] {  // bounds all the others
      const std::size_t n = 2 * near_.size();
      near_.resize(n), pending_.resize(n), boundary_.resize(n), zone_.resize(n);
      near = near_.data(), pending = pending_.data();
    }
    const Triangle& t = all[slot];
    ask(t.n[before[i]], c, b);
    ask(t.n[next_of[i]], a, c);
  }
  zone_size_ = zone_size;
  boundary_size_ = boundary_size;
}

Word Mesh::new_slot() {
  if (!free_.empty()) {
    const Word slot = free_.back();
    free_.pop_back();
    return slot;
  }
  if (triangles.size() >= triangles_max) throw KernelFull();
  triangles.resize(triangles.size() + 1);
  return static_cast<Word>(triangles.size() - 1);
}

// A boundary of k edges encloses k - 2 triangles and takes k new ones: (v, from, from of the next edge).
void Mesh::fill(Vertex v) {
  const std::size_t k = boundary_size_;
  zone_[k - 2] = new_slot();
  zone_[k - 1] = new_slot();
  Triangle* const all = triangles.data();
  const Word* const slots = zone_.data();
  const Edge* const edges = boundary_.data();
  Word previous = slots[k - 1], slot = slots[0];
  Vertex from = edges[0].from;
  for (std::size_t e = 0; e < k; ++e) {
    const std::size_t after = e + 1 < k ? e + 1 : 0;
    const Word across = edges[e].across, next = slots[after];
    const Vertex to = edges[after].from;
    Triangle& t = all[slot];
    t.v[0] = v, t.v[1] = from, t.v[2] = to;
    t.state = State::plain;
    t.n[0] = across, t.n[1] = 4 * next + 2, t.n[2] = 4 * previous + 1;
    if (!(across & frozen_bit)) [[likely]]
      all[across >> 2].n[across & 3] = 4 * slot;
    previous = slot, slot = next, from = to;
  }
  last_ = slots[k - 1];
  if (!indexed_) return;
  if (incident_.size() <= vertices_) incident_.resize(vertices_ + std::size_t{1});
  incident_[v] = last_;
  for (std::size_t e = 0; e < k; ++e) incident_[edges[e].from] = slots[e];
}

void Mesh::insert(Vertex v) {
  const Point p = point(v);
  const Located found = locate(p);
  check(found.same == 0, "points are distinct");
  find_zone(p, found.triangle);
  fill(v);
}

void Mesh::around(Vertex v, std::vector<Word>& found) const {
  if (!indexed_) {
    incident_.resize(vertices_ + std::size_t{1});
    for (Word t = 0; t < triangles.size(); ++t) {
      if (triangles[t].dead()) continue;
      for (const Vertex w : triangles[t].v) incident_[w] = t;
    }
    indexed_ = true;
  }
  found.clear();
  const Word first = incident_[v];
  Word slot = first;
  do {
    const Triangle& t = triangles[slot];
    found.push_back(slot);
    const Word i = t.v[0] == v ? 0 : t.v[1] == v ? 1 : 2;
    const Word across = t.n[next_of[i]];
    check(!(across & frozen_bit), "the triangles around a vertex are not frozen");
    slot = across >> 2;
  } while (slot != first);
}

void Mesh::rebuild() {
  free_.clear();
  indexed_ = false;
  last_ = 0;
  for (Word t = 0; t < triangles.size(); ++t) {
    if (triangles[t].dead()) {
      free_.push_back(t);
    } else {
      last_ = t;
    }
  }
}

std::size_t Mesh::memory() const {
  return triangles.bytes() + own_.bytes() + incident_.bytes() + (free_.capacity() + zone_.capacity()) * sizeof(Word) +
         boundary_.capacity() * sizeof(Edge) + pending_.capacity() * sizeof(Pending) + near_.capacity() * sizeof(Near);
}

// The hole is filled by the triangles, in conflict with the vertex, of the triangulation of the points around it.
bool Mesh::remove(Vertex v) {
  std::vector<Word> star;
  around(v, star);
  struct Outside {
    Vertex from;
    Word across;
  };
  std::vector<Outside> link_of_v;  // the edges of the hole
  std::vector<Vertex> near;
  for (const Word slot : star) {
    const Triangle& t = triangles[slot];
    const Word i = t.v[0] == v ? 0 : t.v[1] == v ? 1 : 2;
    check(!(t.n[i] & frozen_bit), "a removed vertex is not joined to a frozen cell");
    link_of_v.push_back({t.v[next_of[i]], t.n[i]});
    near.push_back(t.v[next_of[i]]);
  }
  std::array<Vertex, 3> first{};  // positions in `near`, from 1, of three points that are not collinear
  const auto find_first = [&] {
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    std::erase_if(near, [&](Vertex w) { return w == v || w == infinite_vertex; });
    for (Vertex i = 3; i <= near.size(); ++i) {
      first = {1, 2, i};
      if (exact::orient2(point(near[0]), point(near[1]), point(near[i - 1])) != 0) return true;
    }
    return false;
  };
  if (!find_first()) {
    // All around v are collinear. The star of v is the same with more points: those across its link.
    for (const Outside& o : link_of_v) near.push_back(triangles[o.across >> 2].v[o.across & 3]);
    if (!find_first()) return false;
  }
  Mesh small;
  for (const Vertex w : near) small.add(point(w));
  small.start(first);
  for (Vertex i = 1; i <= near.size(); ++i) {
    if (std::find(first.begin(), first.end(), i) == first.end()) small.insert(i);
  }
  const Point p = point(v);
  small.find_zone(p, small.locate(p).triangle);

  for (const Word slot : star) {
    triangles[slot].state = State::dead;
    free_.push_back(slot);
  }
  const auto name = [&](Vertex i) { return i == infinite_vertex ? infinite_vertex : near[i - 1]; };
  const auto zone = small.zone();
  std::vector<Word> slots;
  for (std::size_t z = 0; z < zone.size(); ++z) slots.push_back(new_slot());
  const auto slot_of = [&](Word z) {
    return slots[static_cast<std::size_t>(std::find(zone.begin(), zone.end(), z) - zone.begin())];
  };
  for (std::size_t z = 0; z < zone.size(); ++z) {
    const Triangle& from = small.triangles[zone[z]];
    triangles[slots[z]] = {{name(from.v[0]), name(from.v[1]), name(from.v[2])}, State::plain, {}};
  }
  for (std::size_t z = 0; z < zone.size(); ++z) {
    const Triangle& from = small.triangles[zone[z]];
    for (Word i = 0; i < 3; ++i) {
      if (std::find(zone.begin(), zone.end(), from.n[i] >> 2) != zone.end()) {
        triangles[slots[z]].n[i] = 4 * slot_of(from.n[i] >> 2) + (from.n[i] & 3);
        continue;
      }
      const Vertex begin = triangles[slots[z]].v[next_of[i]];
      const auto outside =
          std::find_if(link_of_v.begin(), link_of_v.end(), [&](const Outside& o) { return o.from == begin; });
      check(outside != link_of_v.end(), "the zone of a removed vertex is its link's");
      link(slots[z], i, outside->across);
    }
    for (const Vertex w : triangles[slots[z]].v) incident_[w] = slots[z];
  }
  last_ = slots.front();
  return true;
}

}  // namespace tessera::flat2
