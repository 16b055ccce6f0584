// The harness's network: it holds every packet for a random time, and delivers in random order. Quiescence must not be
// believed while it holds anything.
//
// message       | effect
// share, Packet | keep the packet, and send a tick to itself
// tick          | with some luck deliver one packet, any of them; else try again later
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "actors/harness/memory_faults.h"
#include "actors/protocol.h"

namespace tessera {

struct NetworkState {
  std::uint64_t held = 0;
  MemoryFaults* memory_faults = nullptr;
};

class Network : public NetworkHandle::base {
 public:
  using Trace = std::function<void(const std::string&)>;
  // A held packet is passed over `patience` times on average. `state` outlives the network.
  Network(caf::actor_config& config, NetworkState& state, Trace trace, std::uint64_t seed, std::uint32_t patience);
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  NetworkState& state_;
  Trace trace_;
  std::mt19937_64 rng_;
  std::uint32_t patience_;
  std::vector<std::pair<caf::actor, Packet>> held_;  // with the receiver of each
};

}  // namespace tessera
