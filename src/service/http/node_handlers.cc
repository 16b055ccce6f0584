#include <utility>

#include "src/service/http/handlers.h"

namespace tessera::service::http {
namespace {

Answer nodes(const Call& call) {
  Reply<proto::NodeList> found = call.context.backend->nodes.list();
  if (!found) return problem(found.error());
  found.value().clear_links();
  *found.value().add_links() = call.context.links.link(call.request, "/v1/nodes", "self", json);
  return message_answer(call.request, 200, found.value());
}

Answer drain(const Call& call) {
  const Reply<proto::NodeInfo> drained = call.context.backend->nodes.drain(call.arguments[0], call.request.caller);
  return drained ? message_answer(call.request, 200, drained.value()) : problem(drained.error());
}

}  // namespace

void add_node_routes(std::vector<Route>& routes) {
  routes.push_back({"GET",
                    "/v1/nodes",
                    Role::read,
                    "listNodes",
                    "The nodes that work on the jobs",
                    {{200, json, "NodeList", "The nodes, in the order in which they joined"}},
                    nodes});
  routes.push_back({"POST",
                    "/v1/nodes/{node}/drain",
                    Role::admin,
                    "drainNode",
                    "Drain a node, given by name or id: take all work from it, and let its process end",
                    {{200, json, "NodeInfo", "The node, which is being drained"}},
                    drain});
}

}  // namespace tessera::service::http
