#include "actors/coordinator.h"

#include <utility>

namespace tessera {

Coordinator::Coordinator(caf::actor_config& config, caf::actor owner, std::uint32_t nodes,
                         std::function<void()> on_quiet)
    : caf::event_based_actor(config),
      owner_(std::move(owner)),
      on_quiet_(std::move(on_quiet)),
      detector_(nodes),
      expected_(nodes) {}

// Coordinator and nodes know each other: one that has ended must not keep the others alive.
void Coordinator::on_exit() {
  nodes_.clear();
  owner_ = nullptr;
}

caf::behavior Coordinator::make_behavior() {
  set_error_handler([](caf::scheduled_actor*, caf::error&) {});
  return {
      [this](const std::vector<caf::actor>& nodes) {
        nodes_ = nodes;
        for (const auto& node : nodes_) send(node, Start{});
      },
      [this](const IdleNotice&) {
        if (!collecting_) act(detector_.notice());
      },
      [this](const NodeTally& tally) {
        if (!collecting_) act(detector_.answer(tally.wave, tally.node, tally.idle, {tally.sent, tally.processed}));
      },
      [this](const NodeFinished& done) {
        finished_.insert(done.node);
        if (finished_.size() == expected_ && !std::exchange(ended_, true)) {
          send(owner_, RunEnded{0, "", detector_.wave()});
        }
      },
      [this](const NodeFailed& failed) {
        if (!std::exchange(ended_, true)) send(owner_, RunEnded{failed.code, failed.text, detector_.wave()});
      },
  };
}

void Coordinator::act(QuiescenceDetector::Verdict verdict) {
  switch (verdict) {
    case QuiescenceDetector::Verdict::wait:
      return;
    case QuiescenceDetector::Verdict::probe:
      for (const auto& node : nodes_) send(node, Probe{detector_.wave()});
      return;
    case QuiescenceDetector::Verdict::quiet:
      collecting_ = true;
      if (on_quiet_) on_quiet_();
      send(owner_, RunQuiet{detector_.wave()});
      for (const auto& node : nodes_) send(node, CollectAll{});
      return;
  }
}

}  // namespace tessera
