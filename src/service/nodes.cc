#include "src/service/nodes.h"

#include <algorithm>
#include <chrono>
#include <mutex>

#include "src/cluster/certs/certificates.h"
#include "src/job/machine.h"
#include "src/service/naming.h"
#include "src/service/problem.h"

namespace tessera::service {
namespace {

proto::NodeInfo info_of(const NodeState& node) {
  proto::NodeInfo info;
  info.set_name(node.info.name);
  info.set_id(node.info.uuid);
  info.set_address(node.info.address);
  info.set_threads(node.info.threads);
  info.set_memory_bytes(node.info.memory_bytes);
  info.set_memory_used_bytes(node.use.memory_bytes);
  info.set_scratch_free_bytes(node.use.scratch_free_bytes);
  if (node.info.certificate_end_s > 0) {
    const std::chrono::system_clock::time_point end{std::chrono::seconds(node.info.certificate_end_s)};
    info.set_certificate_until(time_text(end));
    info.set_certificate_warning(expiry_warning(end, std::chrono::system_clock::now()));
  }
  info.set_state(node.leaves ? "draining" : node.free ? "free" : "joining");
  info.set_seconds(node.seconds);
  info.set_silent_ms(node.silent_ms);
  info.set_coordinator(node.own);
  info.set_last_words(node.last_words);
  return info;
}

}  // namespace

std::map<std::string, std::uint64_t> Nodes::tiles_by_node() const {
  const std::lock_guard lock(jobs_.mutex);
  std::map<std::string, std::uint64_t> tiles;
  for (const auto& id : jobs_.active) {
    const auto& running = jobs_.jobs.at(id)->running;
    if (!running) continue;
    for (const NodeProgress& node : running->progress.nodes()) {
      if (!node.lost) tiles[node.name] += node.tiles - std::min(node.tiles, node.tiles_stored);
    }
  }
  return tiles;
}

NodeState Nodes::own_node() const {
  NodeState own;
  own.info = {{}, host_name(), {}, engine_.threads(), memory_bytes_, 0};
  own.own = own.free = true;
  own.seconds = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - began_).count());
  const std::lock_guard lock(jobs_.mutex);
  own.use.memory_bytes = jobs_.memory_used();
  return own;
}

Reply<proto::NodeList> Nodes::list() {
  proto::NodeList list;
  if (!cluster_) {
    *list.add_nodes() = info_of(own_node());
    return list;
  }
  for (const NodeState& node : engine_.nodes()) *list.add_nodes() = info_of(node);
  const auto tiles = tiles_by_node();
  for (auto& node : *list.mutable_nodes()) {
    if (const auto found = tiles.find(node.name()); found != tiles.end()) node.set_tiles(found->second);
  }
  return list;
}

Reply<proto::NodeInfo> Nodes::drain(std::string_view node, const Caller& caller) {
  if (caller.role < Role::admin) return problem(403, "draining a node needs a token of role admin", Errc::usage);
  BOOST_OUTCOME_TRY(all, list());
  const auto none = [&] { return problem(404, "there is no node '" + std::string(node) + "'", Errc::usage); };
  const auto wanted = std::find_if(all.nodes().begin(), all.nodes().end(), [&](const proto::NodeInfo& info) {
    return info.name() == node || (!info.id().empty() && info.id() == node);
  });
  if (wanted == all.nodes().end()) return none();
  if (!cluster_)
    return problem(
        409,
        "node '" + std::string(node) +
            "': cannot be drained, because this daemon is not part of a cluster; end the daemon instead: its jobs go "
            "on when it starts again",
        Errc::usage);
  proto::NodeInfo info = *wanted;
  // By id, because another node may have the same name.
  const Result<bool> drained = engine_.drain(info.id());
  if (!drained) return problem(409, drained.error().where, Errc::usage);
  if (!drained.value()) return none();
  info.set_state("draining");
  return info;
}

}  // namespace tessera::service
