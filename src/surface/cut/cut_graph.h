// A region's part of a graph of cells, in which a minimum cut is sought. Each cell has an arc across each of its
// facets.
//
// Source and sink are in the excess of each cell. So any pseudoflow is allowed: a cell keeps what does not flow on.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "src/base/big_vector.h"

namespace tessera::cut {

// An arc is 4 cell + facet: it leads out of the cell, across this facet.
using Arc = std::uint32_t;
inline constexpr Arc no_arc = ~Arc{0};  // there is nothing across the facet
// | number of the border: a cell of another region is across the facet
inline constexpr Arc border_bit = Arc{1} << 31u;
inline constexpr std::uint32_t cells_max = std::uint32_t{1} << 29u;

// The most an arc may carry: with what may flow back, the sum fits into 32 bits.
inline constexpr std::uint32_t capacity_max = (std::uint32_t{1} << 31u) - 1;
// An excess that no flow exhausts: a cell's four arcs carry less than 2^33.
inline constexpr std::int64_t infinite_terminal = std::int64_t{1} << 48u;

// The graph of one region.
struct CutGraph {
  // An arc to a cell of another region, and how much may come back across the facet.
  struct Border {
    Arc arc = 0;
    std::uint32_t capacity_in = 0;
  };

  // By cell: what the source gives to it, less what it gives to the sink, plus what has flowed in, less what has flowed
  // out. Within 2^50 either way.
  BigVector<std::int64_t> excess;
  // By arc: what may still flow along it, its residual capacity. With that of the arc back it is at most 2
  // capacity_max.
  BigVector<std::uint32_t> capacity;
  // By arc: the arc back, border_bit | number of the border, or no_arc.
  BigVector<Arc> back;
  std::vector<Border> borders;

  std::uint32_t cells() const { return static_cast<std::uint32_t>(excess.size()); }
  std::size_t bytes() const { return excess.size() * 40 + borders.size() * sizeof(Border); }
  // Whether arcs and arcs back, and borders and their numbers, fit each other.
  bool sound() const;

  // Pushes flow along an arc inside the region. REQUIRES: the arc has this capacity left.
  void push(Arc arc, std::uint32_t flow) {
    capacity[arc] -= flow;
    capacity[back[arc]] += flow;
    excess[arc >> 2u] -= flow;
    excess[back[arc] >> 2u] += flow;
  }
};

inline bool is_inner(Arc back) { return back < border_bit; }

// A set of cells, with one bit a cell.
class CellSet {
 public:
  explicit CellSet(std::size_t cells = 0) : words_((cells + 63) / 64, 0) {}
  bool contains(std::uint32_t cell) const { return words_[cell >> 6u] >> (cell & 63u) & 1u; }
  // Returns whether the cell was not in the set before.
  bool insert(std::uint32_t cell) {
    std::uint64_t& word = words_[cell >> 6u];
    const std::uint64_t bit = std::uint64_t{1} << (cell & 63u);
    const bool fresh = (word & bit) == 0;
    word |= bit;
    return fresh;
  }
  // Returns how many of the cells before this one are in the set.
  std::uint64_t count_before(std::uint32_t cell) const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < cell >> 6u; ++i) sum += static_cast<std::uint64_t>(std::popcount(words_[i]));
    const std::uint64_t before = (std::uint64_t{1} << (cell & 63u)) - 1;
    return before == 0 ? sum : sum + static_cast<std::uint64_t>(std::popcount(words_[cell >> 6u] & before));
  }
  // Whether the set was made for this number of cells.
  bool holds(std::size_t cells) const { return words_.size() == (cells + 63) / 64; }
  // The set in the form in which it is kept: 64 cells a word.
  const std::vector<std::uint64_t>& words() const { return words_; }
  static CellSet of_words(std::vector<std::uint64_t> words) {
    CellSet set;
    set.words_ = std::move(words);
    return set;
  }
  friend bool operator==(const CellSet&, const CellSet&) = default;

 private:
  std::vector<std::uint64_t> words_;
};

}  // namespace tessera::cut
