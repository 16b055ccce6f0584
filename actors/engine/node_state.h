// What is known of a node.
#pragma once

#include <cstdint>

#include "src/cluster/members.h"

namespace tessera {

// A node of a cluster, as its coordinator sees it.
struct NodeState {
  MemberInfo info;
  bool own = false;  // of the coordinator's process
  bool free = false, draining = false;
  std::uint64_t seconds = 0, silent_ms = 0;  // since it came, since it was heard
  std::uint64_t memory_used = 0;
};

}  // namespace tessera
