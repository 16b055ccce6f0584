// The sent-set: which tile has been told of which vertex. Most vertices are told to one tile only. That tile stands in
// an array by vertex; a hash set has the others. The set must be fast, as a star asks for each pair of its vertices
// many times.
#pragma once

#include <tsl/robin_set.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/check.h"
#include "src/base/mix_hash.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

// A set of pairs (vertex, tile). Not thread-safe.
class SentSet {
 public:
  // Adds a pair. Returns false if it was in the set before.
  bool add(Vertex v, TileId tile) {
    if (v >= first_.size()) first_.resize(v + 1, nobody);
    if (first_[v] == tile) return false;
    if (first_[v] != nobody) return more_.insert(key_of(v, tile)).second;
    first_[v] = tile;
    return true;
  }

  bool has(Vertex v, TileId tile) const {
    if (v >= first_.size() || first_[v] == nobody) return false;
    return first_[v] == tile || more_.contains(key_of(v, tile));
  }

  // Renames vertex v to to[v]. REQUIRES: for all v in the set, to[v] is not 0, and all to[v] differ.
  void renumber(const std::vector<Vertex>& to) {
    SentSet renumbered;
    for (const std::uint64_t key : keys()) {
      const Vertex v = to[key >> 32];
      check(v != 0, "only vertices of cells that are not final have been shared");
      renumbered.add(v, TileId{static_cast<std::uint32_t>(key)});
    }
    *this = std::move(renumbered);
  }

  // Returns all pairs, as vertex << 32 | tile.
  std::vector<std::uint64_t> keys() const {
    std::vector<std::uint64_t> all(more_.begin(), more_.end());
    for (std::size_t v = 0; v < first_.size(); ++v) {
      if (first_[v] != nobody) all.push_back(key_of(static_cast<Vertex>(v), first_[v]));
    }
    return all;
  }

  std::size_t memory() const { return first_.capacity() * sizeof(TileId) + more_.bucket_count() * 16; }

 private:
  static constexpr TileId nobody{~std::uint32_t{0}};
  static std::uint64_t key_of(Vertex v, TileId tile) { return std::uint64_t{v} << 32 | tile.value; }

  std::vector<TileId> first_;
  tsl::robin_set<std::uint64_t, MixHash> more_;
};

}  // namespace tessera
