// The harness's network: holds every batch for a random while and delivers in random order. Quiescence must not be
// believed while it holds anything.
//
// message | effect
// Batch   | keep it; ask myself for a delivery later
// deliver | with some luck pass one batch on, any of them; else try again later
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <random>
#include <vector>

#include "actors/protocol.h"
#include "actors/tile_actor.h"

namespace tessera {

struct NetworkState {
  std::uint64_t held = 0;
};

class Network : public caf::event_based_actor {
 public:
  // `patience`: a held batch is passed over up to this many times on average.
  Network(caf::actor_config& config, const Directory& directory, NetworkState& state, std::uint64_t seed,
          std::uint32_t patience);
  caf::behavior make_behavior() override;

 private:
  const Directory& directory_;
  NetworkState& state_;
  std::mt19937_64 rng_;
  std::uint32_t patience_;
  std::vector<Batch> held_;
};

}  // namespace tessera
