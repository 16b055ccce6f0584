// Going through the cells: lists, exploration and freezing.
#include <bit>

#include "src/base/check.h"
#include "src/kernel/flat_kernel_3_impl.h"

namespace tessera::flat {

CellList FlatKernel3::cells() const {
  const Array<Cell>& all = mesh_.cells;
  CellList list;
  const std::size_t live = mesh_.live_cells();
  list.vertices.resize(4 * live);
  list.neighbors.resize(4 * live);
  std::vector<Word> rank;  // of each slot, where some are free
  if (live < all.size()) {
    rank.resize(all.size());
    Word n = 0;
    for (std::size_t c = 0; c < all.size(); ++c) {
      rank[c] = n;
      n += !all[c].dead();
    }
  }
  Vertex* vertex = list.vertices.data();
  std::uint32_t* neighbor = list.neighbors.data();
  for (std::size_t c = 0; c < all.size(); ++c) {
    if (all[c].dead()) continue;
    for (int i = 0; i < 4; ++i) {
      const Word across = all[c].n[i];
      *vertex++ = all[c].v[i] & vertex_mask;
      *neighbor++ = across & frozen_bit ? across : rank.empty() ? across >> 2 : rank[across >> 2];
    }
  }
  return list;
}

std::vector<Word> FlatKernel3::mark_open(const std::function<bool(const Vertex*)>& settled) {
  Cell* const all = mesh_.cells.data();
  std::vector<Word> seen;
  const auto visit = [&](Word slot) {
    Cell& c = all[slot];
    if (c.v[0] > vertex_mask) return;
    std::uint8_t labels = is_local_bit;
    for (const Word v : c.v) labels &= labels_[v];
    c.v[0] |= labels && settled(c.v) ? mark_out : mark_in;
    seen.push_back(slot);
  };
  std::vector<Word> around, first;  // all of them before any is marked: marks stop the walk around a vertex
  for (Vertex v = 0; v <= vertices(); ++v) {
    if ((labels_[v] & is_local_bit) || !alive(v)) continue;
    mesh_.around(v, around);
    first.insert(first.end(), around.begin(), around.end());
  }
  for (const Word slot : first) visit(slot);
  for (std::size_t next = 0; next < seen.size(); ++next) {
    const Cell& c = all[seen[next]];
    if ((c.v[0] & ~vertex_mask) != mark_in) continue;
    for (const Word across : c.n) {
      if (!(across & frozen_bit)) visit(across >> 2);
    }
  }
  return seen;
}

std::vector<Vertex> FlatKernel3::explore(const std::function<bool(const Vertex*)>& settled, CellList* all,
                                         std::vector<std::uint8_t>* open) {
  const std::vector<Word> seen = mark_open(settled);
  Array<Cell>& cells = mesh_.cells;
  if (all) {
    *all = this->cells();
    open->clear();
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (!cells[c].dead()) open->push_back((cells[c].v[0] & ~vertex_mask) == mark_in);
    }
  }
  std::vector<Vertex> found;
  for (const Word slot : seen) {
    Cell& c = cells[slot];
    const bool is_open = (c.v[0] & ~vertex_mask) == mark_in;
    c.v[0] &= vertex_mask;
    if (is_open) found.insert(found.end(), c.v, c.v + 4);
  }
  return found;
}

// One pass in the order of the slots: a bit a cell and their ranks tell every cell's new number, so no cell needs to be
// read twice, and what has been passed can be given back at once.
FrozenCells FlatKernel3::freeze(const std::function<bool(const Vertex*)>& settled) {
  check(dimension_ == 3 && !mesh_.frozen(), "a kernel is frozen once");
  mesh_.compact();
  const std::vector<Word> seen = mark_open(settled);
  Array<Cell> old = mesh_.take_cells();
  const std::size_t n = old.size();
  std::vector<std::uint64_t> open_bits(n / 64 + 1);
  for (const Word slot : seen) {
    Cell& c = old[slot];
    if ((c.v[0] & ~vertex_mask) == mark_in) open_bits[slot / 64] |= std::uint64_t{1} << slot % 64;
    c.v[0] &= vertex_mask;
  }
  std::vector<Word> open_before(open_bits.size() + 1);
  for (std::size_t w = 0; w < open_bits.size(); ++w) {
    open_before[w + 1] = open_before[w] + static_cast<Word>(std::popcount(open_bits[w]));
  }
  const auto is_open = [&](Word slot) { return (open_bits[slot / 64] >> slot % 64 & 1) != 0; };
  const auto rank = [&](Word slot) {  // open cells before it
    return open_before[slot / 64] +
           static_cast<Word>(std::popcount(open_bits[slot / 64] & ((std::uint64_t{1} << slot % 64) - 1)));
  };
  const std::size_t open_cells = open_before.back(), frozen = n - open_cells;
  FrozenCells out;
  out.vertices.reserve(4 * frozen);
  out.neighbors.reserve(4 * frozen);
  Array<Cell>& live = mesh_.cells;
  live.reserve(2 * open_cells + 64);
  live.resize(open_cells);
  constexpr Word chunk = Word{1} << 18;
  for (Word slot = 0; slot < n; ++slot) {
    const Cell& c = old[slot];
    if (is_open(slot)) {
      Cell& kept = live[rank(slot)];
      kept = c;
      for (Word& across : kept.n) {
        const Word to = across >> 2;
        across = is_open(to) ? 4 * rank(to) + (across & 3) : frozen_bit | (4 * (to - rank(to)) + (across & 3));
      }
    } else {
      for (int i = 0; i < 4; ++i) {
        const Word to = c.n[i] >> 2;
        out.vertices.push_back(c.v[i]);
        out.neighbors.push_back(is_open(to) ? FrozenCells::open : to - rank(to));
      }
    }
    if (slot % chunk == chunk - 1) old.release_front(slot);
  }
  frozen_cells_ = static_cast<std::uint32_t>(frozen);
  mesh_.set_frozen(frozen > 0);
  mesh_.rebuild();
  return out;
}

}  // namespace tessera::flat
