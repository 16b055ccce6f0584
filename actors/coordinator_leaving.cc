// Nodes that are to leave in order: what they have goes on elsewhere, and none of it begins again.
//
// the job    | what must be done before the node may go
// finding    | it is waited until it is known where the parts are; it is asked for its own, too, as it may have said
//            | to the coordinator before this one that it leaves
// opening    | nothing has begun: its tiles are others'
// exchanging | HandOver to its part, which writes an image of each tile that has begun, and ends. A table of a new
//            | epoch then has them elsewhere, as other incarnations, which begin from these images
// settling   | it is waited
// collecting | what it has it stores
// finishing, ending | it is waited
#include <algorithm>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"

namespace tessera {

void Coordinator::leave(const NodeLeaves& leaves) {
  const auto node = caf::actor_cast<NodeHandle>(leaves.node);
  if (state_ == State::finding) join(node);
  leaving_.push_back({node, caf::actor_cast<UsherHandle>(leaves.registry)});
}

bool Coordinator::leaves(const NodeHandle& node) const {
  return std::any_of(leaving_.begin(), leaving_.end(), [&](const Leaving& one) { return one.node == node; });
}

// After every step, for with each the job may have come to where they can go.
void Coordinator::let_go() {
  for (std::size_t i = 0; i < leaving_.size() && !told_;) {
    if (!may_go(leaving_[i].node)) {
      ++i;
      continue;
    }
    const Leaving one = leaving_[i];
    leaving_.erase(leaving_.begin() + static_cast<std::ptrdiff_t>(i));
    send(one.registry, NodeLet{caf::actor_cast<caf::actor>(one.node), caf::actor_cast<caf::actor>(this)});
  }
}

bool Coordinator::may_go(const NodeHandle& node) {
  if (state_ == State::finding) return !knows(node);
  const auto part =
      std::find_if(parts_.begin(), parts_.end(), [&](const PartOf& p) { return p.node == node && !p.ended; });
  if (part == parts_.end()) return true;
  const NodeId number{static_cast<std::uint32_t>(part - parts_.begin())};
  if (state_ == State::finishing || state_ == State::ending) return false;
  if (state_ == State::opening || !part->opened) {
    dismiss(number);
    return true;
  }
  if (state_ == State::exchanging && handing_.insert(number).second) send(part->part, HandOver{});
  if (state_ == State::collecting && part->collected && !std::exchange(part->finished, true))
    send(part->part, Finish{});
  return false;
}

// It has begun nothing.
void Coordinator::dismiss(NodeId node) {
  PartOf& p = parts_[node.value];
  p.lost = p.ended = p.left = true;
  if (p.part) {
    demonitor(p.part.address());
    p.abort.say(p.part);
    p.part = nullptr;
  }
  if (nobody()) return wait_for_a_node(failure_of(error(Errc::internal, "the last node has left")));
  if (state_ == State::opening) begin_if_opened();
}

// It has handed over, or has stored what it had.
void Coordinator::left(const PartEnded& message) {
  PartOf& p = parts_[message.node.value];
  p.lost = p.left = true;
  if (handing_.erase(message.node) > 0) {
    std::vector<bool> moves(options_.weights.size());
    for (const TileId t : released_) moves[t.value] = true;
    for (const TileId t : options_.order) {
      if (table_.node_of(t) == message.node && !stored_[t.value] && !moves[t.value]) released_.push_back(t);
    }
    account_.tiles_begin_again(message.not_handed);
  }
  if (!p.name.empty()) {
    owner_.said("node " + p.name + " leaves: others go on with " + std::to_string(message.handed) +
                " tiles that it had begun" +
                (message.not_handed == 0 ? "" : "; " + std::to_string(message.not_handed) + " begin again"));
  }
  detector_.restart(nodes());
  if (nobody()) return wait_for_a_node(failure_of(error(Errc::internal, "the last node has left")));
  place_orphans();
}

// `back`: another process of a node that has had a part in this job.
void Coordinator::note(const NodeBack& back) {
  const bool took_part = std::any_of(parts_.begin(), parts_.end(),
                                     [&](const PartOf& p) { return !p.name.empty() && p.name == back.name; });
  if (took_part) owner_.said("node " + back.name + ": the process before this one " + back.last_words);
}

}  // namespace tessera
