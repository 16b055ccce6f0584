// A set of source indices.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <tsl/robin_set.h>

#include "src/base/ids.h"
#include "src/base/mix_hash.h"

namespace tessera {

// Where a good part of all points is in the set, every point of a result is asked for. Then the set is a bit for each
// source index, which fits into caches, and takes no more memory than a hash set would.
class PointIds {
 public:
  PointIds() = default;
  explicit PointIds(std::span<const PointId> ids) {
    reserve(ids);
    insert(ids);
  }

  // Makes room for these.
  void reserve(std::span<const PointId> ids) {
    if (ids.empty()) return;
    const std::uint64_t words = std::max_element(ids.begin(), ids.end())->value / 64 + 1;
    if (words <= std::uint64_t{words_for_one} * ids.size()) {
      bits_.resize(std::max<std::size_t>(bits_.size(), words));
    } else {
      others_.reserve(ids.size());
    }
  }
  // Returns whether it is new.
  bool insert(PointId id) {
    if (!has_bit(id)) return others_.insert(id).second;
    std::uint64_t& word = bits_[id.value / 64];
    const std::uint64_t bit = std::uint64_t{1} << id.value % 64;
    const bool fresh = (word & bit) == 0;
    word |= bit;
    in_bits_ += fresh ? 1 : 0;
    return fresh;
  }
  void insert(std::span<const PointId> ids) {
    for (const PointId id : ids) insert(id);
  }
  void erase(PointId id) {
    if (!contains(id)) return;
    if (!has_bit(id)) {
      others_.erase(id);
      return;
    }
    bits_[id.value / 64] &= ~(std::uint64_t{1} << id.value % 64);
    --in_bits_;
  }
  bool contains(PointId id) const {
    return has_bit(id) ? (bits_[id.value / 64] >> id.value % 64 & 1u) != 0 : others_.contains(id);
  }
  std::size_t size() const { return in_bits_ + others_.size(); }
  bool empty() const { return size() == 0; }
  // All, ascending.
  std::vector<PointId> sorted() const {
    std::vector<PointId> all(others_.begin(), others_.end());
    all.reserve(size());
    for (std::size_t i = 0; i < bits_.size(); ++i) {
      for (std::uint64_t word = bits_[i]; word != 0; word &= word - 1)
        all.push_back(PointId{i * 64 + static_cast<std::uint64_t>(std::countr_zero(word))});
    }
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  static constexpr std::size_t words_for_one = 4;
  bool has_bit(PointId id) const { return id.value / 64 < bits_.size(); }

  std::vector<std::uint64_t> bits_;  // of the first source indices
  std::size_t in_bits_ = 0;
  tsl::robin_set<PointId, MixHash> others_;
};

}  // namespace tessera
