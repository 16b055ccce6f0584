#include "actors/harness/network.h"

#include <utility>

namespace tessera {

Network::Network(caf::actor_config& config, NetworkState& state, Trace trace, std::uint64_t seed,
                 std::uint32_t patience)
    : NetworkHandle::base(config), state_(state), trace_(std::move(trace)), rng_(seed), patience_(patience) {}

void Network::on_exit() { held_.clear(); }

Network::behavior_type Network::make_behavior() {
  const Turn ours(state_.memory_faults, false);
  return {
      [this](caf::actor& share, Packet& packet) {
        const Turn ours(state_.memory_faults, false);
        held_.emplace_back(share, std::move(packet));
        state_.held = held_.size();
        send(this, caf::tick_atom_v);
      },
      [this](caf::tick_atom) {
        const Turn ours(state_.memory_faults, false);
        if (rng_() % (patience_ + 1) != 0) {
          send(this, caf::tick_atom_v);
          return;
        }
        std::swap(held_[rng_() % held_.size()], held_.back());
        auto [share, packet] = std::move(held_.back());
        held_.pop_back();
        state_.held = held_.size();
        for (const Update& update : packet.updates) {
          if (trace_) trace_("network: delivers " + to_string(update));
        }
        send(caf::actor_cast<ShareHandle>(share), std::move(packet));
      },
  };
}

}  // namespace tessera
