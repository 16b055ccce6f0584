#include "actors/network.h"

#include <utility>

namespace tessera {

Network::Network(caf::actor_config& config, const Directory& directory, NetworkState& state, std::uint64_t seed,
                 std::uint32_t patience)
    : caf::event_based_actor(config), directory_(directory), state_(state), rng_(seed), patience_(patience) {}

caf::behavior Network::make_behavior() {
  return {
      [this](Batch& batch) {
        held_.push_back(std::move(batch));
        state_.held = held_.size();
        send(this, caf::tick_atom_v);
      },
      [this](caf::tick_atom) {
        if (rng_() % (patience_ + 1) != 0) {
          send(this, caf::tick_atom_v);
          return;
        }
        std::swap(held_[rng_() % held_.size()], held_.back());
        Batch batch = std::move(held_.back());
        held_.pop_back();
        state_.held = held_.size();
        directory_.tell([&] { return "network: delivers " + to_string(batch); });
        const caf::actor& tile = directory_.tiles[batch.to.tile.value];
        send(tile, std::move(batch));
      },
  };
}

}  // namespace tessera
