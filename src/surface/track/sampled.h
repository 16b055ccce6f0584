// Keeps a sample of things with a flight line and a time: all things of some times, in whatever order they come.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "src/base/mixed_bits.h"

namespace tessera {

// `Timed`: has `line` and `time`. Of one line and time, keeps all things or none.
template <class Timed>
class Sampled {
 public:
  explicit Sampled(std::size_t most) : most_(most) {}

  // The limit is the largest 2^64 / 2^k with which at most `most` things are kept.
  void add(const Timed& one) {
    if (hash_of(one) > limit_) return;
    kept_.push_back(one);
    while (kept_.size() > most_) lower(limit_ / 2);
  }
  void add(const Sampled& others) {
    for (const Timed& one : others.kept_) add(one);
    // What the others have dropped must not stay here either.
    if (others.limit_ < limit_) lower(others.limit_);
  }

  // Returns what was kept, sorted by `key`, each key once; nothing is left.
  template <class Key>
  std::vector<Timed> take(const Key& key) {
    std::sort(kept_.begin(), kept_.end(), [&](const Timed& a, const Timed& b) { return key(a) < key(b); });
    // The same point may come twice, as in files that overlap.
    kept_.erase(
        std::unique(kept_.begin(), kept_.end(), [&](const Timed& a, const Timed& b) { return key(a) == key(b); }),
        kept_.end());
    return std::exchange(kept_, {});
  }

 private:
  static std::uint64_t hash_of(const Timed& one) {
    return mixed_bits(std::bit_cast<std::uint64_t>(one.time) ^ mixed_bits(one.line));
  }
  void lower(std::uint64_t limit) {
    limit_ = limit;
    std::erase_if(kept_, [&](const Timed& one) { return hash_of(one) > limit_; });
  }

  std::size_t most_;
  std::uint64_t limit_ = ~std::uint64_t{0};  // largest hash that is kept
  std::vector<Timed> kept_;
};

}  // namespace tessera
