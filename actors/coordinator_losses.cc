// Losses of nodes: their tiles begin again on other nodes. When no node is left, the coordinator waits for one.
#include <algorithm>
#include <iterator>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"

namespace tessera {
namespace {

std::string gone(const caf::down_msg& down) { return "does not answer any more: " + in_words(down.reason); }

}  // namespace

void Coordinator::lose(const NodeHandle& node, Failure failure, const std::string& why) {
  if (course_.is(At::finding)) return lose_found(node);
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    if (parts_[n].node == node) return lose(NodeId{n}, std::move(failure), why);
  }
}

// A node is lost while shares are looked for, before or after it has answered. When it has answered, its share may
// still send messages, so no other node gets its number.
void Coordinator::lose_found(const NodeHandle& node) {
  const bool asked = std::erase(asked_, node) > 0;
  const auto answered = std::erase_if(answers_, [&](const ShareFound& found) {
    if (caf::actor_cast<NodeHandle>(found.node) != node) return false;
    if (found.part) numbers_lost_ = std::max(numbers_lost_, found.self.value + 1);
    return true;
  });
  // The nodes that are left may be unable to open their shares. Counting a wait makes the job wait for others then.
  if (asked || answered > 0) ++waits_;
  if ((asked || answered > 0) && nobody())
    return wait_for_a_node(failure_of(error(Errc::internal, "the last node is lost")));
  if (asked_.empty() && (asked || without_room_)) {
    without_room_ = false;
    take_over();
  }
}

void Coordinator::lose(NodeId node, Failure failure, const std::string& why) {
  if (roster_[node].over()) return;
  Participant& p = parts_[node.value];
  roster_[node].standing = Standing::lost;
  if (p.part) {
    account_.node_lost();
    demonitor(p.part.address());
  }
  p.part = nullptr;
  missing(node, std::move(failure), why);
}

// The node has no share any more.
void Coordinator::missing(NodeId node, Failure failure, const std::string& why) {
  if (course_.ends()) return finish_if_over();
  if (!course_.is(At::opening)) orphan_tiles(node, why);
  if (nobody()) return wait_for_a_node(std::move(failure));
  if (course_.is(At::opening)) return begin_if_opened();
  place_orphans();
}

void Coordinator::orphan_tiles(NodeId node, const std::string& why) {
  const std::size_t tiles = placements_.lose(node);
  if (const std::string& name = roster_[node].name; !name.empty()) {
    owner_.said("node " + name + " is lost" + (why.empty() ? "" : ": it " + why) + "; " + std::to_string(tiles) +
                " tiles begin again on others");
  }
  // Nothing that the node has said, or still says, counts, even while there is no other node that takes the tiles.
  detector_.restart(nodes());
  if (tiles > 0) is_disturbed();
}

// The job goes on without the node, if there are others. A job that no node can open, though none was lost, fails.
void Coordinator::not_opened(const ShareOpened& message) {
  roster_[message.node].standing = Standing::refused;
  if (course_.ends()) return finish_if_over();
  if (roster_.all_refused() && waits_ == 0) return fail(message.failure);
  owner_.said((message.name.empty() ? "a node" : "node " + message.name) +
              " cannot take part: " + message.failure.text);
  if (nobody()) return wait_for_a_node(message.failure);
  if (course_.is(At::opening)) begin_if_opened();
}

// No share is there, and none is being opened.
bool Coordinator::nobody() const {
  return course_.is(At::finding) ? asked_.empty() && answers_.empty() : roster_.nobody();
}

// The process of the lost node may come again, and others may be on their way. `failure` is told when none comes.
void Coordinator::wait_for_a_node(Failure failure, const std::string& because) {
  const std::uint32_t patience_s = options_.spec.grace_s;
  if (patience_s == 0) return fail(std::move(failure));
  missed_ = std::move(failure);
  owner_.said(because + ": the job waits " + std::to_string(patience_s) + " s for another one");
  delayed_send(this, std::chrono::seconds(patience_s), NobodyCame{++waits_});
}

void Coordinator::give_up_waiting(const NobodyCame& over) {
  const bool waits = over.wait == waits_ && !course_.ends();
  if (waits && (nobody() || without_room_)) fail(std::move(missed_));
}

void Coordinator::lost_actor(const caf::down_msg& down) {
  const auto asked =
      std::find_if(asked_.begin(), asked_.end(), [&](const NodeHandle& node) { return node.address() == down.source; });
  if (asked != asked_.end()) return lose(NodeHandle(*asked), lost("a node", down.reason), gone(down));
  for (std::uint32_t n = 0; n < parts_.size(); ++n) {
    const Participant& p = parts_[n];
    const bool node = p.node && down.source == p.node.address();
    const bool part = p.part && down.source == p.part.address();
    if ((!node && !part) || roster_[NodeId{n}].over()) continue;
    if (node && roster_[NodeId{n}].there()) continue;  // its share lives on, or will be missed by itself
    return lose(NodeId{n}, lost(node ? "a node" : "a node's part of the job", down.reason), gone(down));
  }
}

// Places all homeless tiles at once, when all of them are known. Until then nothing is believed quiet, or finished.
void Coordinator::place_orphans() {
  const std::vector<Host> there = hosts();
  if (placements_.awaits() || there.empty()) return;  // a share that is being opened will take the tiles
  const Placements::Placed placed = placements_.place(there, lives());
  account_.tiles_begin_again(placed.again);
  if (placements_.homeless().empty()) {
    without_room_ = false;
  } else {
    wait_for_room(placements_.homeless());
  }
  if (!placed.changes.empty()) return change_table(placed.changes);
  if (course_.is(At::exchanging)) {
    detector_.restart(nodes());
    act(detector_.look());
  }
  // A node that is lost without tiles may have been the last one that was waited for.
  collect_if_settled();
  finish_if_collected();
}

}  // namespace tessera
