#include "src/quiescence/detector.h"

namespace tessera {

QuiescenceDetector::Verdict QuiescenceDetector::begin() {
  ++wave_;
  in_wave_ = true;
  noticed_ = false;
  all_idle_ = true;
  sum_ = {};
  answered_.clear();
  return Verdict::probe;
}

void QuiescenceDetector::restart(std::set<NodeId> nodes) {
  nodes_ = std::move(nodes);
  in_wave_ = false;
  previous_.reset();
}

QuiescenceDetector::Verdict QuiescenceDetector::notice() {
  if (!in_wave_) return begin();
  noticed_ = true;
  return Verdict::wait;
}

QuiescenceDetector::Verdict QuiescenceDetector::answer(std::uint64_t wave, NodeId node, bool idle, Totals totals) {
  if (!in_wave_ || wave != wave_ || !nodes_.contains(node) || !answered_.insert(node).second) return Verdict::wait;
  all_idle_ &= idle;
  sum_ += totals;
  return answered_.size() == nodes_.size() ? judge() : Verdict::wait;
}

QuiescenceDetector::Verdict QuiescenceDetector::judge() {
  in_wave_ = false;
  const bool could_be_quiet = all_idle_ && sum_.sent == sum_.processed;
  if (could_be_quiet && previous_ == sum_) return Verdict::quiet;
  previous_.reset();
  if (could_be_quiet) {
    previous_ = sum_;
    return begin();
  }
  return noticed_ ? begin() : Verdict::wait;
}

}  // namespace tessera
