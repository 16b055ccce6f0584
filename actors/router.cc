#include "actors/router.h"

#include <algorithm>
#include <utility>

#include "actors/failing.h"

namespace tessera {

Router::Router(caf::actor_config& config, RouterOptions options, RoutingOwner& owner,
               const std::vector<NodeHandle>& nodes)
    : SteadyActor(config),
      options_(std::move(options)),
      owner_(&owner),
      nodes_(nodes),
      routed_(options_.here.size()),
      left_(routed_.size()) {
  for (std::uint32_t i = 0; i < left_; ++i) (options_.here[i] ? for_owner_ : waiting_).push_back(i);
}

Router::behavior_type Router::make_behavior() {
  // Receivers that are gone are noticed by the monitors.
  set_error_handler([](caf::scheduled_actor*, caf::error&) {});
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { lose(down.source); });
  for (const NodeHandle& node : nodes_) monitor(node);
  hand_out();
  return {
      [this](SplitRouted& routed) { take(routed); },
      [this](const NodeLost& lost) { lose(lost.node.address()); },
      [this](const NodeJoined& joined) { join(caf::actor_cast<NodeHandle>(joined.node)); },
      [this](const NodeLeaves& leaves) {  // its split goes to another node at once
        lose(leaves.node.address());
        send(caf::actor_cast<UsherHandle>(leaves.registry), NodeLet{leaves.node, caf::actor_cast<caf::actor>(this)});
      },
      [](const NodeBack&) {},
      [this](const Cancel&) { end(failure_of(error(Errc::interrupted, "interrupted while input was routed"))); },
  };
}

void Router::on_exit() {
  end(ended_unexpectedly());
  nodes_.clear();
  at_work_.clear();
}

void Router::failed(const std::exception_ptr& exception) noexcept {
  end(failure_of(exception, [] { return std::string("routing input"); }));
}

void Router::join(const NodeHandle& node) {
  if (std::find(nodes_.begin(), nodes_.end(), node) != nodes_.end()) return;
  nodes_.push_back(node);
  monitor(node);
  hand_out();
}

void Router::lose(const caf::actor_addr& node) {
  std::erase_if(nodes_, [&](const NodeHandle& known) { return known.address() == node; });
  for (auto at = at_work_.begin(); at != at_work_.end();) {
    if (at->second.node && at->second.node.address() == node) {
      waiting_.push_front(at->second.split);
      at = at_work_.erase(at);
    } else {
      ++at;
    }
  }
  hand_out();
}

void Router::take(SplitRouted& routed) {
  const auto found = at_work_.find(routed.attempt);
  if (found == at_work_.end()) return;  // from a node that was lost
  found->second.routed = routed.routed;
  if (routed.done) {
    const Attempt attempt = found->second;
    at_work_.erase(found);
    if (!routed.failure) {
      routed_[attempt.split] = routed.attempt;
      routed_so_far_ += attempt.routed;
      --left_;
    } else if (!attempt.node) {
      return end(std::move(routed.failure));
    } else {
      std::erase(nodes_, attempt.node);
      for_owner_.push_back(attempt.split);
      why_here_ = std::move(routed.failure.text);
    }
    hand_out();
  }
  std::uint64_t so_far = routed_so_far_;
  for (const auto& [number, attempt] : at_work_) so_far += attempt.routed;
  if (owner_) owner_->progressed(so_far);
  if (left_ == 0) end({});
}

void Router::hand_out() {
  if (!owner_) return;
  for (const NodeHandle& node : nodes_) {
    const auto busy = [&](const auto& entry) { return entry.second.node == node; };
    if (waiting_.empty() || std::any_of(at_work_.begin(), at_work_.end(), busy)) continue;
    const std::uint32_t split = waiting_.front();
    waiting_.pop_front();
    send(node, RouteSplit{options_.run_folder, split, begin(split, node), options_.shares,
                          caf::actor_cast<caf::actor>(this)});
  }
  const bool owner_busy =
      std::any_of(at_work_.begin(), at_work_.end(), [](const auto& entry) { return !entry.second.node; });
  if (owner_busy) return;
  auto& from = for_owner_.empty() && nodes_.empty() ? waiting_ : for_owner_;
  if (from.empty()) return;
  const std::uint32_t split = from.front();
  from.pop_front();
  owner_->route_here(split, begin(split, {}), std::exchange(why_here_, {}));
}

std::uint32_t Router::begin(std::uint32_t split, NodeHandle node) {
  at_work_[++attempts_] = {split, std::move(node), 0};
  return attempts_;
}

// Nodes that still work notice that the router is gone.
void Router::end(Failure failure) noexcept {
  if (!owner_) return;
  std::exchange(owner_, nullptr)->ended(std::move(routed_), std::move(failure));
  quit();
}

}  // namespace tessera
