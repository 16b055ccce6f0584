#include "src/exchange/detector.h"

namespace tessera {

QuiescenceDetector::Verdict QuiescenceDetector::begin() {
  ++wave_.value;
  in_wave_ = true;
  noticed_ = false;
  all_idle_ = true;
  sum_ = {};
  answered_.clear();
  return Verdict::probe;
}

QuiescenceDetector::Verdict QuiescenceDetector::begin_if_worth() {
  const bool worth = !in_wave_ && noticed_ && idle_.size() == nodes_.size();
  return worth ? begin() : Verdict::wait;
}

void QuiescenceDetector::restart(std::set<NodeId> nodes) {
  nodes_ = std::move(nodes);
  std::erase_if(idle_, [&](NodeId node) { return !nodes_.contains(node); });
  in_wave_ = false;
  noticed_ = true;
  previous_.reset();
}

void QuiescenceDetector::restart_busy(std::set<NodeId> nodes) {
  idle_.clear();
  restart(std::move(nodes));
}

QuiescenceDetector::Verdict QuiescenceDetector::notice(NodeId node) {
  if (!nodes_.contains(node)) return Verdict::wait;
  idle_.insert(node);
  noticed_ = true;
  return begin_if_worth();
}

QuiescenceDetector::Verdict QuiescenceDetector::look() { return nodes_.empty() ? Verdict::wait : begin_if_worth(); }

QuiescenceDetector::Verdict QuiescenceDetector::answer(Wave wave, NodeId node, bool idle, Totals totals) {
  if (!in_wave_ || wave != wave_ || !nodes_.contains(node) || !answered_.insert(node).second) return Verdict::wait;
  if (!idle) idle_.erase(node);
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
  return begin_if_worth();
}

}  // namespace tessera
