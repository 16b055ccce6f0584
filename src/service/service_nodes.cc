// The nodes that work on the jobs: those of a cluster, or this process alone.
#include <algorithm>
#include <chrono>
#include <map>
#include <string>

#include "src/cluster/certs/certificates.h"
#include "src/job/machine.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/service/service_impl.h"

namespace tessera {
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

std::map<std::string, std::uint64_t> Service::Impl::tiles_by_node() {
  const std::lock_guard lock(mutex);
  std::map<std::string, std::uint64_t> tiles;
  for (const auto& id : active) {
    const auto& running = jobs.at(id)->running;
    if (!running) continue;
    for (const NodeProgress& node : running->progress.nodes()) {
      if (!node.lost) tiles[node.name] += node.tiles - std::min(node.tiles, node.tiles_stored);
    }
  }
  return tiles;
}

Reply<proto::NodeList> Service::nodes() {
  proto::NodeList list;
  if (impl_->options.cluster) {
    for (const NodeState& node : impl_->engine->nodes()) *list.add_nodes() = info_of(node);
    const auto tiles = impl_->tiles_by_node();
    for (auto& node : *list.mutable_nodes()) {
      if (const auto found = tiles.find(node.name()); found != tiles.end()) node.set_tiles(found->second);
    }
    return list;
  }
  NodeState self;
  self.info = {{}, host_name(), {}, impl_->options.threads, impl_->options.memory_bytes, 0};
  self.own = self.free = true;
  self.seconds = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - impl_->began).count());
  self.use.memory_bytes = figures().memory_used_bytes;
  *list.add_nodes() = info_of(self);
  return list;
}

Reply<proto::NodeInfo> Service::drain(std::string_view node, const Caller& caller) {
  if (caller.role < Role::admin) return problem(403, "to drain a node takes the role admin", Errc::usage);
  BOOST_OUTCOME_TRY(list, nodes());
  const auto none = [&] { return problem(404, "there is no node '" + std::string(node) + "'", Errc::usage); };
  const auto wanted = std::find_if(list.nodes().begin(), list.nodes().end(), [&](const proto::NodeInfo& info) {
    return info.name() == node || (!info.id().empty() && info.id() == node);
  });
  if (wanted == list.nodes().end()) return none();
  if (!impl_->options.cluster)
    return problem(
        409, "node '" + std::string(node) + "': this daemon is no cluster: end it, and its jobs go on when it is back",
        Errc::usage);
  proto::NodeInfo info = *wanted;
  // By id, because another node may have the same name.
  const Result<bool> drained = impl_->engine->drain(info.id());
  if (!drained) return problem(409, drained.error().where, Errc::usage);
  if (!drained.value()) return none();
  info.set_state("draining");
  return info;
}

}  // namespace tessera
