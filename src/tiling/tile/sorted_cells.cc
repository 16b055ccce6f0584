// Mostly a handful of cells have a least vertex in common. They are sorted by counting, for each cell, how many come
// before it. So no branch depends on the values that are compared.
#include "src/tiling/tile/sorted_cells.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <utility>
#include <vector>

#include "src/base/stopped.h"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed to functions that are always inlined
#endif

namespace tessera {
namespace {

using Quad = std::uint32_t __attribute__((vector_size(16)));
using Signed = std::int32_t __attribute__((vector_size(16)));
using Lanes = std::int64_t __attribute__((vector_size(32)));

// Which entries of a row come first, second, ...
using Turn = Quad;

// Turns by the outcomes of the comparisons 0<1, 0<2, 0<3, 1<2, 1<3, 2<3 of a row's entries; the first comparison is the
// highest bit.
struct Turns {
  Turn of[64];
};

constexpr Turns turns_3() {
  constexpr std::uint8_t pairs[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};  // two swaps each
  constexpr std::uint8_t rest[4][3] = {{}, {1, 2, 3}, {2, 3, 1}, {3, 1, 2}};
  Turns turns{};
  for (unsigned outcomes = 0; outcomes < 64; ++outcomes) {
    bool less[4][4] = {};
    for (int i = 0, bit = 5; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j, --bit) {
        less[i][j] = outcomes >> bit & 1;
        less[j][i] = !less[i][j];
      }
    }
    int least = 0;
    for (int i = 1; i < 4; ++i) least = less[i][least] ? i : least;
    const std::uint8_t* p = pairs[least];
    int second = 1;
    for (int i = 2; i < 4; ++i) second = less[p[i]][p[second]] ? i : second;
    const std::uint8_t* r = rest[second];
    turns.of[outcomes] = Turn{p[0], p[r[0]], p[r[1]], p[r[2]]};
  }
  return turns;
}

// In 2D there are three comparisons: 0<1, 0<2, 1<2.
constexpr Turns turns_2() {
  Turns turns{};
  for (unsigned outcomes = 0; outcomes < 8; ++outcomes) {
    const bool a = outcomes & 4, b = outcomes & 2, c = outcomes & 1;
    turns.of[outcomes] = a && b ? Turn{0, 1, 2, 3} : !a && c ? Turn{1, 2, 0, 3} : Turn{2, 0, 1, 3};
  }
  return turns;
}

template <int d>
constexpr Turns all_turns = d == 3 ? turns_3() : turns_2();

template <int d>
[[gnu::always_inline]] inline Turn turn_of(const std::uint32_t* w) {
  unsigned outcomes = w[0] < w[1];
  outcomes = 2 * outcomes + (w[0] < w[2]);
  if constexpr (d == 3) outcomes = 2 * outcomes + (w[0] < w[3]);
  outcomes = 2 * outcomes + (w[1] < w[2]);
  if constexpr (d == 3) outcomes = 2 * outcomes + (w[1] < w[3]), outcomes = 2 * outcomes + (w[2] < w[3]);
  return all_turns<d>.of[outcomes];
}

[[gnu::always_inline]] inline Quad turned(Quad row, Turn turn) {
#if defined(__clang__)
  return Quad{row[turn[0]], row[turn[1]], row[turn[2]], row[turn[3]]};
#else
  return __builtin_shuffle(row, turn);
#endif
}

[[gnu::always_inline]] inline Quad load(const std::uint32_t* at) {
  Quad quad;
  std::memcpy(&quad, at, sizeof quad);
  return quad;
}

// A row after its turn. Vertices are those in the mesh.
struct Turned {
  Quad vertices;
  Turn turn;
};

template <int d>
class Rows {
 public:
  static constexpr std::size_t corners = d + 1;
  static constexpr std::size_t ahead = 64;

  explicit Rows(const SortedCells& cells) : cells_(cells), last_(cells.order.size() - 1) {}

  // Rows in canonical order are anywhere in memory. The rows that come soon are prefetched.
  [[gnu::always_inline]] std::uint32_t soon(std::size_t at) const {
    const std::uint32_t row = cells_.order[std::min(at + ahead, last_)] & ~mixed_row;
    __builtin_prefetch(&cells_.rows[row]);
    return row;
  }

  // `see` is called with each foreign vertex, as numbered in the mesh.
  template <class See>
  [[gnu::always_inline]] Turned turned_row(std::uint32_t o, const See& see) const {
    const CellRecord& row = cells_.rows[o & ~mixed_row];
    if (!(o & mixed_row)) [[likely]] {
      const Turn turn = turn_of<d>(row.vertices);
      return {turned(load(row.vertices), turn) - 1, turn};
    }
    std::uint32_t w[4] = {};
    for (std::size_t i = 0; i < corners; ++i) {
      w[i] = row.vertices[i] - 1;
      if (w[i] < cells_.own) continue;
      w[i] = cells_.index[w[i] - cells_.own];
      see(w[i]);
    }
    const Turn turn = turn_of<d>(w);
    return {turned(load(w), turn), turn};
  }

  [[gnu::always_inline]] void copy_vertices(std::size_t first, std::size_t count, std::int32_t* to) const {
    for (std::size_t at = first; at < first + count; ++at, to += corners) {
      soon(at);
      const Turned cell = turned_row(cells_.order[at], [](std::uint32_t) {});
      std::memcpy(to, &cell.vertices, corners * sizeof *to);
    }
  }

  [[gnu::always_inline]] void copy_neighbors(std::size_t first, std::size_t count, std::int32_t* to) const {
    const std::int32_t* const mesh_index = cells_.mesh_index;
    for (std::size_t at = first; at < first + count; ++at, to += corners) {
      soon(at);
      const std::uint32_t o = cells_.order[at];
      const Turned cell = turned_row(o, [](std::uint32_t) {});
      // The shift removes the facet numbers. Values that are no neighbour stay negative.
      const Signed n = reinterpret_cast<Signed>(load(cells_.rows[o & ~mixed_row].neighbors)) >> 2;
      const Quad t = turned(reinterpret_cast<Quad>(n), cell.turn);
      for (std::size_t i = 0; i < corners; ++i) to[i] = mesh_index[static_cast<std::int32_t>(t[i])];
    }
  }

 private:
  const SortedCells cells_;  // a copy, so that no write can change it
  const std::size_t last_;
};

template <int d>
class Sorter {
 public:
  Sorter(const SortedCells& cells, const CellsToSort& sorted, const std::stop_token& stop)
      : cells_(cells), sorted_(sorted), stop_(stop) {}

  // Sorts several buckets at a time, so that one is written while another is read.
  [[gnu::always_inline]] void sort() {
    const std::span<const std::uint32_t> ends = sorted_.end;
    std::size_t begin = 0;
    for (std::size_t v = 0; v < ends.size();) {
      throw_if_stopped(stop_);
      const std::size_t first = v;
      do {
        ++v;
      } while (v < ends.size() && ends[v] - begin <= usual);
      const std::size_t end = ends[v - 1];
      read(begin, end);
      std::size_t k = 0;
      for (std::size_t w = first; w < v; ++w) {
        const std::size_t bucket_end = ends[w] - begin;
        bucket_end - k > few ? rank_many(k, bucket_end) : rank(k, bucket_end);
        k = bucket_end;
      }
      put(begin, end);
      begin = end;
    }
  }

 private:
  struct Entry {
    std::uint32_t o, ghost;
  };

  [[gnu::always_inline]] void read(std::size_t begin, std::size_t end) {
    if (end - begin > entries_.size()) {
      entries_.resize(end - begin);
      keys_.resize(end - begin + 3);
      ranks_.resize(end - begin + 3);
    }
    const Rows<d> rows(cells_);
    Entry* const entries = entries_.data();
    std::int64_t* const keys = keys_.data();
    for (std::size_t i = 0; i < end - begin; ++i) {
      __builtin_prefetch(sorted_.mesh_index + rows.soon(begin + i), 1);
      const std::uint32_t o = cells_.order[begin + i];
      std::uint32_t ghost = 0;
      const Turned cell =
          rows.turned_row(o, [&](std::uint32_t foreign) { ghost |= sorted_.owners[foreign] < sorted_.self; });
      entries[i] = {o, ghost};
      // In a bucket the next two vertices distinguish all cells: a positively oriented cell is the only one on its side
      // of the facet (least, second, third). In 2D, on its side of an edge.
      keys[i] = std::int64_t{cell.vertices[1]} << 32 | cell.vertices[2];
    }
  }

  [[gnu::always_inline]] void put(std::size_t begin, std::size_t end) {
    std::uint32_t* const order = sorted_.order.data() + begin;
    std::uint8_t* const ghost = sorted_.ghost + begin;
    std::int32_t* const mesh_index = sorted_.mesh_index;
    for (std::size_t i = 0; i < end - begin; ++i) {
      const Entry e = entries_[i];
      const auto rank = static_cast<std::size_t>(ranks_[i]);
      order[rank] = e.o;
      if (sorted_.ghost) ghost[rank] = static_cast<std::uint8_t>(e.ghost);
      mesh_index[e.o & ~mixed_row] = static_cast<std::int32_t>(sorted_.first + begin + rank);
    }
  }

  // Finds where the cells of a bucket go: behind as many as have smaller keys. Writes whole lanes.
  [[gnu::always_inline]] void rank(std::size_t begin, std::size_t end) {
    const std::int64_t* const keys = keys_.data();
    const auto first = static_cast<std::int64_t>(begin);
    for (std::size_t i = begin; i < end; i += 4) {
      Lanes mine, place{first, first, first, first};
      std::memcpy(&mine, keys + i, sizeof mine);
      for (std::size_t j = begin; j < end; ++j) place -= Lanes{keys[j], keys[j], keys[j], keys[j]} < mine;
      std::memcpy(ranks_.data() + i, &place, sizeof place);
    }
  }

  void rank_many(std::size_t begin, std::size_t end) {
    std::vector<std::size_t> order(end - begin);
    std::iota(order.begin(), order.end(), begin);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys_[a] < keys_[b]; });
    for (std::size_t i = 0; i < order.size(); ++i) ranks_[order[i]] = static_cast<std::int64_t>(begin + i);
  }

  static constexpr std::size_t usual = 256;  // cells
  static constexpr std::size_t few = 64;     // from here on std::sort is faster
  const SortedCells cells_;
  const CellsToSort sorted_;
  const std::stop_token& stop_;
  std::vector<Entry> entries_;
  std::vector<std::int64_t> keys_, ranks_;
};

// Runs the work with the best instructions of the machine.
#if defined(__x86_64__)
template <class Do>
[[gnu::target("avx2")]] void avx2(const Do& work) {
  work();
}
#endif

template <class Do>
void best(const Do& work) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return avx2(work);
#endif
  work();
}

template <int d>
void sort_dimension(const SortedCells& cells, const CellsToSort& sorted, const std::stop_token& stop) {
  Sorter<d> sorter(cells, sorted, stop);
  best([&]() __attribute__((always_inline)) { sorter.sort(); });
}

}  // namespace

void sort_cells(int dimension, const SortedCells& cells, const CellsToSort& sorted, const std::stop_token& stop) {
  if (sorted.order.empty()) return;
  dimension == 3 ? sort_dimension<3>(cells, sorted, stop) : sort_dimension<2>(cells, sorted, stop);
}

void copy_vertices(int dimension, const SortedCells& cells, std::size_t first, std::size_t count, std::int32_t* to) {
  if (dimension == 3) {
    best([&]() __attribute__((always_inline)) { Rows<3>(cells).copy_vertices(first, count, to); });
  } else {
    best([&]() __attribute__((always_inline)) { Rows<2>(cells).copy_vertices(first, count, to); });
  }
}

void copy_neighbors(int dimension, const SortedCells& cells, std::size_t first, std::size_t count, std::int32_t* to) {
  if (dimension == 3) {
    best([&]() __attribute__((always_inline)) { Rows<3>(cells).copy_neighbors(first, count, to); });
  } else {
    best([&]() __attribute__((always_inline)) { Rows<2>(cells).copy_neighbors(first, count, to); });
  }
}

Status stream_cells(int dimension, const SortedCells& cells, CopyCells copy, const CellStream::Consumer& take) {
  constexpr std::size_t piece_cells = 1024;  // 16 KiB, which stay in the first-level cache until they are taken
  const std::size_t corners = static_cast<std::size_t>(dimension) + 1;
  std::array<std::int32_t, 4 * piece_cells> piece;
  for (std::size_t first = 0; first < cells.order.size(); first += piece_cells) {
    const std::size_t count = std::min(piece_cells, cells.order.size() - first);
    copy(dimension, cells, first, count, piece.data());
    BOOST_OUTCOME_TRYV(take(std::span(piece).first(count * corners)));
  }
  return success();
}

}  // namespace tessera
