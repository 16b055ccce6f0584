// Nodes that leave in order: other nodes go on with what they have, and none of it begins again.
//
// the job    | what must be done before the node may go
// finding    | wait until it is known where the shares are. The node is asked for its share, too, because it may have
//            | told the coordinator before this one that it leaves
// opening    | nothing, because no tile has begun: its tiles go to others
// exchanging | HandOver to its share, which writes an image of each tile that has begun, and ends. A table of a new
//            | epoch then places the tiles elsewhere, as other incarnations, which begin from these images
// settling   | wait
// collecting | the node stores what it has
// finishing, ending | wait
#include <algorithm>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"

namespace tessera {

void Coordinator::leave(const NodeLeaves& leaves) {
  const auto node = caf::actor_cast<NodeHandle>(leaves.node);
  if (course_.is(At::finding)) join(node);
  leaving_.push_back({node, caf::actor_cast<UsherHandle>(leaves.registry)});
}

bool Coordinator::leaves(const NodeHandle& node) const {
  return std::any_of(leaving_.begin(), leaving_.end(), [&](const Leaving& one) { return one.node == node; });
}

// Called after every step, because each step may bring the job to where nodes can go.
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
  if (course_.is(At::finding)) return !knows(node);
  NodeId number;
  while (number.value < parts_.size() && (parts_[number.value].node != node || roster_[number].over())) ++number.value;
  if (number.value == parts_.size()) return true;
  if (course_.ends()) return false;
  Roster::Node& known = roster_[number];
  if (course_.is(At::opening) || !known.there()) {
    dismiss(number);
    return true;
  }
  const ShareHandle& part = parts_[number.value].part;
  if (course_.is(At::exchanging) && placements_.begin_handing(number)) send(part, HandOver{});
  if (course_.is(At::collecting) && known.reached == Reached::collected && !std::exchange(known.dismissed, true))
    send(part, Finish{});
  return false;
}

// The node's share has begun nothing.
void Coordinator::dismiss(NodeId node) {
  Participant& p = parts_[node.value];
  roster_[node].standing = Standing::left;
  if (p.part) {
    demonitor(p.part.address());
    p.abort.say(p.part);
    p.part = nullptr;
  }
  if (nobody()) return wait_for_a_node(failure_of(error(Errc::internal, "the last node has left")));
  if (course_.is(At::opening)) begin_if_opened();
}

// The share has handed over its tiles, or has stored them.
void Coordinator::left(const ShareEnded& message) {
  Roster::Node& node = roster_[message.node];
  node.standing = Standing::left;
  if (placements_.end_handing(message.node)) account_.tiles_begin_again(message.not_handed);
  if (!node.name.empty()) {
    owner_.said("node " + node.name + " leaves: others go on with " + std::to_string(message.handed) +
                " tiles that it had begun" +
                (message.not_handed == 0 ? "" : "; " + std::to_string(message.not_handed) + " begin again"));
  }
  detector_.restart(nodes());
  if (nobody()) return wait_for_a_node(failure_of(error(Errc::internal, "the last node has left")));
  place_orphans();
}

// `back` tells of a new process of a node. Says so in the job's log when the node has had a share of the job.
void Coordinator::note(const NodeBack& back) {
  const bool took_part = std::any_of(roster_.nodes().begin(), roster_.nodes().end(), [&](const Roster::Node& node) {
    return !node.name.empty() && node.name == back.name;
  });
  if (took_part) owner_.said("node " + back.name + ": the process before this one " + back.last_words);
}

}  // namespace tessera
