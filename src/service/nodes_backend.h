// What front ends ask of the nodes that work on jobs.
#pragma once

#include <string_view>

#include "service.pb.h"
#include "src/service/caller.h"
#include "src/service/reply.h"

namespace tessera::service {

// Thread-safe.
class NodesBackend {
 public:
  virtual ~NodesBackend() = default;
  // In the order in which the nodes joined.
  virtual Reply<proto::NodeList> list() = 0;
  // Takes all work from a node, given by name or id, and ends its process. Returns the node; 409 for the only node.
  virtual Reply<proto::NodeInfo> drain(std::string_view node, const Caller& caller) = 0;
};

}  // namespace tessera::service
