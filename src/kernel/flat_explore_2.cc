// Going through the triangles: lists, exploration and freezing.
#include "src/base/check.h"
#include "src/kernel/flat_kernel_2_impl.h"

namespace tessera::flat2 {

template <class Counts>
std::vector<Word> FlatKernel2::ranks(Counts&& counts) const {
  std::vector<Word> rank(mesh_.triangles.size());
  Word n = 0;
  for (std::size_t slot = 0; slot < rank.size(); ++slot) {
    rank[slot] = n;
    n += counts(mesh_.triangles[slot]);
  }
  return rank;
}

CellList FlatKernel2::cells() const {
  const Array<Triangle>& all = mesh_.triangles;
  CellList list;
  const std::size_t live = mesh_.live_triangles();
  list.vertices.resize(3 * live);
  list.neighbors.resize(3 * live);
  std::vector<Word> rank;  // where some slots are free
  if (live < all.size()) rank = ranks([](const Triangle& t) { return !t.dead(); });
  Vertex* vertex = list.vertices.data();
  std::uint32_t* neighbor = list.neighbors.data();
  for (std::size_t slot = 0; slot < all.size(); ++slot) {
    const Triangle& t = all[slot];
    if (t.dead()) continue;
    for (Word i = 0; i < 3; ++i) {
      const Word across = t.n[i];
      *vertex++ = t.v[i];
      *neighbor++ = across & frozen_bit ? across : rank.empty() ? across >> 2 : rank[across >> 2];
    }
  }
  return list;
}

std::vector<Word> FlatKernel2::mark_open(const std::function<bool(const Vertex*)>& settled) {
  std::vector<Word> seen;
  const auto visit = [&](Word slot) {
    Triangle& t = mesh_.triangles[slot];
    if (t.state != State::plain) return;
    const bool all_local = labels_[t.v[0]] & labels_[t.v[1]] & labels_[t.v[2]] & is_local_bit;
    t.state = all_local && settled(t.v) ? State::settled : State::open;
    seen.push_back(slot);
  };
  std::vector<Word> around;
  for (Vertex v = 0; v <= vertices(); ++v) {
    if (is_local(v) || !alive(v)) continue;
    mesh_.around(v, around);
    for (const Word slot : around) visit(slot);
  }
  for (std::size_t next = 0; next < seen.size(); ++next) {
    const Triangle& t = mesh_.triangles[seen[next]];
    if (t.state != State::open) continue;
    for (const Word across : t.n) {
      if (!(across & frozen_bit)) visit(across >> 2);
    }
  }
  return seen;
}

std::vector<Vertex> FlatKernel2::explore(const std::function<bool(const Vertex*)>& settled, CellList* all,
                                         std::vector<std::uint8_t>* open) {
  const std::vector<Word> seen = mark_open(settled);
  if (all) {
    *all = cells();
    open->clear();
    for (std::size_t slot = 0; slot < mesh_.triangles.size(); ++slot) {
      const Triangle& t = mesh_.triangles[slot];
      if (!t.dead()) open->push_back(t.state == State::open);
    }
  }
  std::vector<Vertex> found;
  for (const Word slot : seen) {
    Triangle& t = mesh_.triangles[slot];
    if (t.state == State::open) found.insert(found.end(), t.v, t.v + 3);
    t.state = State::plain;
  }
  return found;
}

// One pass in the order of the slots: what has been passed can be given back at once.
FrozenCells FlatKernel2::freeze(const std::function<bool(const Vertex*)>& settled) {
  check(dimension_ == 2 && frozen_ == 0, "a kernel is frozen once");
  mark_open(settled);
  const auto is_open = [](const Triangle& t) { return t.state == State::open; };
  const auto is_frozen = [](const Triangle& t) { return t.state == State::plain || t.state == State::settled; };
  const std::vector<Word> open_rank = ranks(is_open), frozen_rank = ranks(is_frozen);
  Array<Triangle> old = std::move(mesh_.triangles);
  const Word n = static_cast<Word>(old.size());
  std::vector<bool> opened(n);
  Word open_triangles = 0;
  for (Word slot = 0; slot < n; ++slot) {
    opened[slot] = is_open(old[slot]);
    open_triangles += opened[slot];
    frozen_ += is_frozen(old[slot]);
  }
  FrozenCells out;
  out.vertices.reserve(3 * std::size_t{frozen_});
  out.neighbors.reserve(3 * std::size_t{frozen_});
  mesh_.drop_triangles();
  mesh_.triangles.reserve(2 * std::size_t{open_triangles} + 64);
  constexpr Word chunk = Word{1} << 18;
  for (Word slot = 0; slot < n; ++slot) {
    Triangle t = old[slot];
    if (opened[slot]) {
      t.state = State::plain;
      for (Word& across : t.n) {
        const Word to = across >> 2, edge = across & 3;
        across = opened[to] ? 4 * open_rank[to] + edge : across_frozen | (3 * frozen_rank[to] + edge);
      }
      mesh_.triangles.push_back(t);
    } else if (!t.dead()) {
      for (Word i = 0; i < 3; ++i) {
        const Word to = t.n[i] >> 2;
        out.vertices.push_back(t.v[i]);
        out.neighbors.push_back(opened[to] ? FrozenCells::open : frozen_rank[to]);
      }
    }
    if (slot % chunk == chunk - 1) old.release_front(slot);
  }
  mesh_.rebuild();
  return out;
}

}  // namespace tessera::flat2
