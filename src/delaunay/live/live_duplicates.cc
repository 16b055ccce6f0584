#include "src/delaunay/live/live_duplicates.h"

#include <utility>

namespace tessera {

LiveDuplicates::LiveDuplicates(std::span<const DuplicatePair> pairs) {
  for (const DuplicatePair& pair : pairs) add(pair.duplicate, pair.kept);
}

const std::set<PointId>* LiveDuplicates::of(PointId kept) const {
  const auto found = also_.find(kept);
  return found == also_.end() ? nullptr : &found->second;
}

void LiveDuplicates::add(PointId duplicate, PointId kept) {
  kept_[duplicate] = kept;
  also_[kept].insert(duplicate);
}

void LiveDuplicates::remove(PointId duplicate) {
  const auto found = kept_.find(duplicate);
  const auto also = also_.find(found->second);
  also->second.erase(duplicate);
  if (also->second.empty()) also_.erase(also);
  kept_.erase(found);
}

void LiveDuplicates::inherit(PointId kept, PointId heir) {
  if (has(heir)) remove(heir);
  const auto found = also_.find(kept);
  if (found == also_.end()) return;
  for (const PointId duplicate : found->second) kept_[duplicate] = heir;
  also_[heir] = std::move(found->second);
  also_.erase(found);
}

// As the nodes of maps and sets take it from the heap.
std::size_t LiveDuplicates::memory() const { return kept_.size() * (64 + 48) + also_.size() * 112; }

std::vector<DuplicatePair> LiveDuplicates::pairs() const {
  std::vector<DuplicatePair> out;
  for (const auto& [duplicate, kept] : kept_) out.push_back({duplicate, kept});
  return out;
}

}  // namespace tessera
