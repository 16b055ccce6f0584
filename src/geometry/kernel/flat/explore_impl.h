// Functions that go through all cells: lists of cells, exploration and freezing.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "src/geometry/kernel/flat/flat_kernel_impl.h"

namespace tessera::flat {

// A set of slots that tells how many members lie before a slot. It takes one bit a slot, and one count for 64 slots.
class Ranks {
 public:
  explicit Ranks(std::size_t slots) : bits_(slots / 64 + 1), before_(bits_.size() + 1) {}
  void set(Index slot) { bits_[slot / 64] |= std::uint64_t{1} << slot % 64; }
  // Computes the counts. To be called after the last set().
  void count() {
    for (std::size_t w = 0; w < bits_.size(); ++w) before_[w + 1] = before_[w] + ones(bits_[w]);
  }
  [[gnu::always_inline]] bool operator[](Index slot) const { return (bits_[slot / 64] >> slot % 64 & 1) != 0; }
  [[gnu::always_inline]] Index before(Index slot) const {
    const std::uint64_t lower = bits_[slot / 64] & ((std::uint64_t{1} << slot % 64) - 1);
    return before_[slot / 64] + ones(lower);
  }
  Index all() const { return before_.back(); }

 private:
  [[gnu::always_inline]] static Index ones(std::uint64_t bits) { return static_cast<Index>(std::popcount(bits)); }
  std::vector<std::uint64_t> bits_;
  std::vector<Index> before_;
};

// Runs `work` with the processor's instruction for counting bits if it has one. Without the target attribute the
// compiler may not use the instruction and calls a function.
#if defined(__x86_64__)
template <class Do>
[[gnu::target("popcnt")]] void with_popcnt(const Do& work) {
  work();
}
#endif
template <class Do>
void counting_fast(const Do& work) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("popcnt")) return with_popcnt(work);
#endif
  work();
}

// Goes once through the slots in order. Cells around an edge lie near each other in this order. So a small table of the
// last edges avoids most repeated visits.
template <class Mesh>
void FlatKernel<Mesh>::edges_from(Vertex first, const std::function<void(Vertex, Vertex)>& visit) const {
  constexpr int table_bits = 12;
  std::vector<std::uint64_t> last(std::size_t{1} << table_bits, 0);
  const auto edge = [&](Vertex v, Vertex w) {
    if (v < w) std::swap(v, w);
    if (v < first || w == infinite_vertex) return;
    const std::uint64_t key = std::uint64_t{v} << 32 | w;
    std::uint64_t& seen = last[key * 0x9E3779B97F4A7C15u >> (64 - table_bits)];  // Fibonacci hashing (Knuth, 6.4)
    if (seen == key) return;
    seen = key;
    visit(v, w);
  };
  for (Index slot = 0; slot < mesh_.cells.size(); ++slot) {
    const Cell& c = mesh_.cells[slot];
    if (c.dead() || std::none_of(c.v, c.v + corners, [&](Vertex v) { return v >= first; })) continue;
    for (Index i = 1; i < corners; ++i) {
      for (Index k = 0; k < i; ++k) edge(c.v[i], c.v[k]);
    }
  }
}

template <class Mesh>
CellList FlatKernel<Mesh>::cells() const {
  const Array<Cell>& all = mesh_.cells;
  const Index slots = static_cast<Index>(all.size());
  const bool gaps = mesh_.live_cells() < slots;
  Ranks live(gaps ? slots : 0);
  for (Index slot = 0; slot < slots && gaps; ++slot) {
    if (!all[slot].dead()) live.set(slot);
  }
  live.count();
  CellList list;
  list.vertices.resize(corners * mesh_.live_cells());
  list.neighbors.resize(corners * mesh_.live_cells());
  Vertex* vertex = list.vertices.data();
  std::uint32_t* neighbor = list.neighbors.data();
  for (Index slot = 0; slot < slots; ++slot) {
    const Cell& c = all[slot];
    if (c.dead()) continue;
    for (Index i = 0; i < corners; ++i) {
      const Index across = c.n[i];
      *vertex++ = c.vertex(i);
      *neighbor++ = across & frozen_bit ? across : gaps ? live.before(across >> 2) : across >> 2;
    }
  }
  return list;
}

template <class Mesh>
CellRecords FlatKernel<Mesh>::take_cells() {
  for (const Index slot : mesh_.free_slots()) mesh_.cells[slot].v[0] = CellRecord::gap;
  Array<Cell> all = mesh_.take_cells();
  reset();
  static_assert(offsetof(Cell, v) == offsetof(CellRecord, vertices) &&
                offsetof(Cell, n) == offsetof(CellRecord, neighbors) && cells_max == CellRecord::most);
  return all.template take_as<CellRecord>();
}

template <class Mesh>
std::vector<Index> FlatKernel<Mesh>::mark_open(const std::function<bool(const Vertex*)>& is_final) {
  Cell* const all = mesh_.cells.data();
  std::vector<Index> seen;
  const auto visit = [&](Index slot) {
    Cell& c = all[slot];
    if (c.marked()) return;
    std::uint8_t labels = is_local_bit;
    for (const Vertex v : c.v) labels &= labels_[v];
    c.mark(!labels || !is_final(c.v));
    seen.push_back(slot);
  };
  std::vector<Index> around, first;  // all cells, before one is marked: marks would stop the walk around a vertex
  for (Vertex v = 0; v <= vertices(); ++v) {
    if (is_local(v) || !alive(v)) continue;
    mesh_.around(v, around);
    first.insert(first.end(), around.begin(), around.end());
  }
  for (const Index slot : first) visit(slot);
  for (std::size_t next = 0; next < seen.size(); ++next) {
    const Cell& c = all[seen[next]];
    if (!c.open()) continue;
    for (const Index across : c.n) {
      if (!(across & frozen_bit)) visit(across >> 2);
    }
  }
  return seen;
}

template <class Mesh>
std::vector<Vertex> FlatKernel<Mesh>::explore(const std::function<bool(const Vertex*)>& is_final, CellList* all,
                                              std::vector<std::uint8_t>* open) {
  const std::vector<Index> seen = mark_open(is_final);
  Array<Cell>& cells = mesh_.cells;
  if (all) {
    *all = this->cells();
    open->clear();
    for (std::size_t slot = 0; slot < cells.size(); ++slot) {
      if (!cells[slot].dead()) open->push_back(cells[slot].open());
    }
  }
  std::vector<Vertex> found;
  for (const Index slot : seen) {
    Cell& c = cells[slot];
    const bool is_open = c.open();
    c.unmark();
    if (is_open) found.insert(found.end(), c.v, c.v + corners);
  }
  return found;
}

// Returns which of the cells `seen` are marked as open, and removes all their marks.
template <class Cell>
Ranks take_open(const std::vector<Index>& seen, Array<Cell>& cells) {
  Ranks open(cells.size());
  for (const Index slot : seen) {
    if (cells[slot].open()) open.set(slot);
    cells[slot].unmark();
  }
  open.count();
  return open;
}

// An array of `cells` cells with address space for the cells that foreign points will add.
template <class Cell>
Array<Cell> room_for(Index cells) {
  Array<Cell> room;
  room.reserve(2 * std::size_t{cells} + 64);
  room.resize(cells);
  return room;
}

// Goes once through the slots in order. A bit for each cell and the ranks of the bits give every cell's new number. So
// no cell is read twice, and final cells stay in the array in which they are.
template <class Mesh>
FinalCells FlatKernel<Mesh>::freeze(const std::function<bool(const Vertex*)>& is_final) {
  check(full() && mesh_.frozen() == 0, "a kernel is frozen once");
  mesh_.compact();
  const std::vector<Index> seen = mark_open(is_final);
  Array<Cell> old = mesh_.take_cells();
  const Index n = static_cast<Index>(old.size());
  const Ranks open = take_open(seen, old);
  const Index frozen = n - open.all();
  Array<Cell> rest = room_for<Cell>(open.all());
  counting_fast([&]() __attribute__((always_inline)) {
    Cell *final = old.data(), *other = rest.data();
    for (Index slot = 0; slot < n; ++slot) {
      Cell c = old[slot];
      if (open[slot]) {
        for (Index& across : c.n) {
          const Index to = across >> 2, facet = across & 3, rank = open.before(to);
          across = open[to] ? 4 * rank + facet : frozen_bit | (corners * (to - rank) + facet);
        }
        *other++ = c;
      } else {
        for (Index& across : c.n) {
          const Index to = across >> 2;
          across = open[to] ? FinalCells::open : 4 * (to - open.before(to)) + (across & 3);
        }
        *final++ = c;
      }
    }
  });
  old.resize(frozen);
  old.trim();
  mesh_.adopt(std::move(rest), frozen);
  return {old.template take_as<CellRecord>(), open.all()};
}

// Reads final cells once, in the order of the slots, and writes nothing to them. Only the cells that stay are copied
// and renumbered.
template <class Mesh>
std::uint64_t FlatKernel<Mesh>::discard(const std::function<bool(const Vertex*)>& is_final, const TakeVertices& told) {
  check(full() && mesh_.frozen() == 0, "a kernel is frozen once");
  mesh_.release_scratch();
  const std::vector<Index> seen = mark_open(is_final);
  const auto gone = static_cast<Index>(mesh_.live_cells());
  Array<Cell> old = mesh_.take_cells();
  const Index n = static_cast<Index>(old.size());
  const Ranks open = take_open(seen, old);
  Array<Cell> rest = room_for<Cell>(open.all());
  constexpr std::size_t batch = 4096 * corners;
  std::vector<Vertex> vertices(batch);
  std::size_t filled = 0;
  counting_fast([&]() __attribute__((always_inline)) {
    Cell* other = rest.data();
    for (Index slot = 0; slot < n; ++slot) {
      const Cell& c = old[slot];
      if (open[slot]) {
        *other = c;
        for (Index& across : other->n) {
          const Index to = across >> 2;
          across = open[to] ? 4 * open.before(to) + (across & 3) : frozen_bit;
        }
        ++other;
      } else if (!c.dead()) {
        std::copy_n(c.v, corners, vertices.begin() + static_cast<std::ptrdiff_t>(filled));
        filled += corners;
        if (filled == batch) {
          told(vertices);
          filled = 0;
        }
      }
    }
  });
  if (filled > 0) told(std::span(vertices).first(filled));
  const Index frozen = gone - open.all();
  mesh_.adopt(std::move(rest), frozen);
  return frozen;
}

}  // namespace tessera::flat
