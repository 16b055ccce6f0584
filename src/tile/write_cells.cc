// A handful of cells have a least vertex in common, most of the time. They are brought into order by counting, for
// each, how many come before it: no branch depends on what is compared.
#include "src/tile/write_cells.h"

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

// Which entries of a row go first, second, ...
using Turn = Quad;

// By the outcomes of the comparisons 0<1, 0<2, 0<3, 1<2, 1<3, 2<3 of a row's entries, the first one the highest bit.
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

// In 2D there are three: 0<1, 0<2, 1<2.
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

struct Entry {
  Quad vertices, neighbors;
  std::uint32_t row, ghost;
  // In a bucket the next two vertices tell all cells apart: a positively oriented cell is the only one on its side of
  // the facet (least, second, third). In 2D, on its side of an edge.
  std::int64_t key() const { return std::int64_t{vertices[1]} << 32 | vertices[2]; }
};

template <int d>
class Writer {
 public:
  static void choose(const CellOrder& from, const WrittenCells& to, const std::stop_token& stop) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) return avx2(from, to, stop);
#endif
    Writer(from, to, stop).write();
  }

 private:
  static constexpr std::size_t corners = d + 1;

  Writer(const CellOrder& from, const WrittenCells& to, const std::stop_token& stop)
      : from_(from), to_(to), stop_(stop), own_(static_cast<std::uint32_t>(from.end.size())) {}
#if defined(__x86_64__)
  [[gnu::target("avx2")]] static void avx2(const CellOrder& from, const WrittenCells& to, const std::stop_token& stop) {
    Writer(from, to, stop).write();
  }
#endif

  // Several buckets at a time, so that one is written while another is read.
  [[gnu::always_inline]] void write() {
    std::size_t begin = 0;
    for (std::size_t v = 0; v < own_;) {
      throw_if_stopped(stop_);
      const std::size_t first = v;
      do {
        ++v;
      } while (v < own_ && from_.end[v] - begin <= usual);
      const std::size_t end = from_.end[v - 1];
      read(begin, end);
      std::size_t k = 0;
      for (std::size_t w = first; w < v; ++w) {
        const std::size_t bucket_end = from_.end[w] - begin;
        bucket_end - k > few ? rank_many(k, bucket_end) : rank(k, bucket_end);
        k = bucket_end;
      }
      put(begin, end);
      begin = end;
    }
  }

  [[gnu::always_inline]] void read(std::size_t begin, std::size_t end) {
    if (end - begin > entries_.size()) {
      entries_.resize(end - begin);
      keys_.resize(end - begin + 3);
      ranks_.resize(end - begin + 3);
    }
    const CellOrder from = from_;
    const std::int32_t* const place = to_.place;
    Entry* const entries = entries_.data();
    std::int64_t* const keys = keys_.data();
    const std::size_t last = from.order.size() - 1;
    for (std::size_t i = 0; i < end - begin; ++i) {
      // Rows in canonical order are anywhere: those that come soon are asked for.
      const std::uint32_t soon = from.order[std::min(begin + i + ahead, last)] & ~mixed_row;
      __builtin_prefetch(&from.rows[soon]);
      __builtin_prefetch(place + soon, 1);
      entries[i] = entry(from, own_, from.order[begin + i]);
      keys[i] = entries[i].key();
    }
  }

  [[gnu::always_inline]] void put(std::size_t begin, std::size_t end) {
    const WrittenCells to = to_;  // nothing that is written can change where it is written
    const Entry* const entries = entries_.data();
    const std::int64_t* const ranks = ranks_.data();
    for (std::size_t i = 0; i < end - begin; ++i) {
      const Entry& e = entries[i];
      const std::size_t at = begin + static_cast<std::size_t>(ranks[i]);
      std::memcpy(to.cells + at * corners, &e.vertices, corners * sizeof(std::int32_t));
      std::memcpy(to.neighbors + at * corners, &e.neighbors, corners * sizeof(std::int32_t));
      to.ghost[at] = static_cast<std::uint8_t>(e.ghost);
      to.place[e.row] = static_cast<std::int32_t>(at);
    }
  }

  [[gnu::always_inline]] static Entry entry(const CellOrder& from, std::uint32_t own, std::uint32_t o) {
    Entry e;
    e.row = o & ~mixed_row;
    e.ghost = 0;
    const CellRow& row = from.rows[e.row];
    // Without the facets; what is no neighbour stays negative.
    const Quad n = reinterpret_cast<Quad>(reinterpret_cast<Signed>(load(row.neighbors)) >> 2);
    if (!(o & mixed_row)) [[likely]] {
      const Turn turn = turn_of<d>(row.vertices);
      e.vertices = turned(load(row.vertices), turn) - 1;
      e.neighbors = turned(n, turn);
      return e;
    }
    std::uint32_t w[4] = {};
    for (std::size_t i = 0; i < corners; ++i) {
      w[i] = row.vertices[i] - 1;
      if (w[i] < own) continue;
      w[i] = from.index[w[i] - own];
      e.ghost |= from.owners[w[i]] < from.self;
    }
    const Turn turn = turn_of<d>(w);
    e.vertices = turned(load(w), turn);
    e.neighbors = turned(n, turn);
    return e;
  }

  // Where the cells of a bucket go: behind as many as have smaller keys. Writes whole lanes.
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
  static constexpr std::size_t ahead = 64;
  static constexpr std::size_t few = 64;  // from here on sorting is faster
  const CellOrder from_;
  const WrittenCells to_;
  const std::stop_token& stop_;
  const std::uint32_t own_;
  std::vector<Entry> entries_;
  std::vector<std::int64_t> keys_, ranks_;
};

}  // namespace

void write_cells(int dimension, const CellOrder& from, const WrittenCells& to, const std::stop_token& stop) {
  dimension == 3 ? Writer<3>::choose(from, to, stop) : Writer<2>::choose(from, to, stop);
}

}  // namespace tessera
