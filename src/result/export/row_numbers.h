// The numbers of rows by the ids of their points, where not all ids have a row.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/ids.h"

namespace tessera::exports {

// Takes 12 bytes for 64 ids, and nothing when each id has a row. REQUIRES: less than 2^32 rows.
class RowNumbers {
 public:
  // Of `rows` rows, with ids below `ids`.
  RowNumbers(std::uint64_t ids, std::uint64_t rows) {
    if (ids == rows) return;
    words_.resize((ids + 63) / 64);
    before_.resize(words_.size());
  }
  // Gives the next number to this id. REQUIRES: ids ascend.
  void add(PointId id) {
    if (words_.empty()) return;
    words_[id.value / 64] |= std::uint64_t{1} << (id.value % 64);
    ++rows_;
    // Words up to the next id begin behind this row.
    for (std::size_t word = filled_ + 1; word <= id.value / 64; ++word) before_[word] = rows_ - 1;
    filled_ = id.value / 64;
  }
  // REQUIRES: the id was added.
  std::uint32_t of(PointId id) const {
    if (words_.empty()) return static_cast<std::uint32_t>(id.value);
    const std::uint64_t below = words_[id.value / 64] & ((std::uint64_t{1} << (id.value % 64)) - 1);
    return before_[id.value / 64] + static_cast<std::uint32_t>(std::popcount(below));
  }
  // Whether the id was added, as far as this is known: of ids that all have a row nothing is noted.
  bool has(PointId id) const {
    return words_.empty() || (id.value / 64 < words_.size() && (words_[id.value / 64] >> (id.value % 64) & 1) != 0);
  }

 private:
  std::vector<std::uint64_t> words_;   // a bit for each id
  std::vector<std::uint32_t> before_;  // by word: rows of the words before
  std::uint32_t rows_ = 0;
  std::size_t filled_ = 0;  // the last word whose entry in before_ is known
};

}  // namespace tessera::exports
