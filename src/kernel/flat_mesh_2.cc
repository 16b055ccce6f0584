#include "src/kernel/flat_mesh_2.h"

#include <algorithm>

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
// and going through it depth first, counterclockwise, gives the boundary in order.
void Mesh::find_zone(const Point& p, Word start) {
  zone_.clear();
  boundary_.clear();
  pending_.clear();
  zone_.push_back(start);
  const Triangle& first = triangles[start];
  pending_.push_back({first.n[1], first.v[2]});
  pending_.push_back({first.n[0], first.v[1]});
  pending_.push_back({first.n[2], first.v[0]});
  while (!pending_.empty()) {
    const Edge edge = pending_.back();
    pending_.pop_back();
    const Word slot = edge.across >> 2, i = edge.across & 3;
    if ((edge.across & frozen_bit) || !conflicts(p, triangles[slot])) {
      boundary_.push_back(edge);
      continue;
    }
    zone_.push_back(slot);
    const Triangle& t = triangles[slot];
    pending_.push_back({t.n[before[i]], t.v[i]});
    pending_.push_back({t.n[next_of[i]], edge.from});
  }
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
  const std::size_t k = boundary_.size();
  zone_.push_back(new_slot());
  zone_.push_back(new_slot());
  Triangle* const all = triangles.data();
  for (std::size_t e = 0; e < k; ++e) {
    const std::size_t next = e + 1 < k ? e + 1 : 0, previous = e > 0 ? e - 1 : k - 1;
    const Word slot = zone_[e], across = boundary_[e].across;
    const Word right = 4 * zone_[next] + 2, left = 4 * zone_[previous] + 1;
    const Vertex from = boundary_[e].from, to = boundary_[next].from;
    all[slot] = {{v, from, to}, State::plain, {across, right, left}};
    if (!(across & frozen_bit)) all[across >> 2].n[across & 3] = 4 * slot;
  }
  last_ = zone_[k - 1];
  if (!indexed_) return;
  if (incident_.size() <= vertices_) incident_.resize(vertices_ + std::size_t{1});
  incident_[v] = last_;
  for (std::size_t e = 0; e < k; ++e) incident_[boundary_[e].from] = zone_[e];
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
         (boundary_.capacity() + pending_.capacity()) * sizeof(Edge);
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
  const auto& zone = small.zone_;
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
