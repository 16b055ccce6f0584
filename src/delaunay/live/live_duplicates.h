// The points of a live result that have the coordinates of a vertex and are none themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "src/base/ids.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Not thread-safe.
class LiveDuplicates {
 public:
  LiveDuplicates() = default;
  explicit LiveDuplicates(std::span<const DuplicatePair> pairs);
  bool has(PointId id) const { return kept_.contains(id); }
  // The duplicates of a vertex, ascending; null if there are none.
  const std::set<PointId>* of(PointId kept) const;
  void add(PointId duplicate, PointId kept);
  void remove(PointId duplicate);
  // Vertex `kept` goes. `heir` takes its place, one of its duplicates or a new point, and has the others from now on.
  void inherit(PointId kept, PointId heir);
  // Ascending.
  std::vector<DuplicatePair> pairs() const;
  std::size_t size() const { return kept_.size(); }
  std::size_t memory() const;

 private:
  std::map<PointId, PointId> kept_;            // by duplicate
  std::map<PointId, std::set<PointId>> also_;  // by vertex
};

}  // namespace tessera
