#include "src/exchange/share.h"

#include "job.pb.h"

namespace tessera {

std::string to_bytes(const ShareSpec& spec) {
  proto::ShareSpec message;
  message.set_run_folder(spec.run_folder);
  message.set_out_folder(spec.out_folder);
  message.set_threads(spec.threads);
  message.set_memory_bytes(spec.memory_bytes);
  message.set_stages(spec.stages);
  message.set_programs(spec.programs);
  message.set_resumable(spec.resumable);
  message.set_lock_file(spec.lock_file);
  message.set_grace_s(spec.grace_s);
  message.set_shares(spec.shares);
  for (const NodeId node : spec.table.nodes) message.add_nodes(node.value);
  for (const Incarnation& incarnation : spec.table.incarnations) {
    message.add_incarnation_terms(incarnation.term.value);
    message.add_incarnations(incarnation.number);
  }
  message.set_epoch_term(spec.table.epoch.term.value);
  message.set_epoch(spec.table.epoch.number);
  message.set_stage(spec.table.stage);
  return message.SerializeAsString();
}

Result<ShareSpec> spec_from_bytes(const std::string& bytes) {
  proto::ShareSpec message;
  const auto refuse = [](const char* what) {
    return error(Errc::internal, std::string("the description of a node's share of a job ") + what);
  };
  if (!message.ParseFromString(bytes)) return refuse("cannot be read");
  if (message.threads() == 0 || message.nodes_size() != message.incarnations_size() ||
      message.nodes_size() != message.incarnation_terms_size()) {
    return refuse("has numbers that no coordinator sends");
  }
  ShareSpec spec;
  spec.run_folder = message.run_folder();
  spec.out_folder = message.out_folder();
  spec.threads = message.threads();
  spec.memory_bytes = message.memory_bytes();
  spec.stages = message.stages();
  spec.programs = message.programs();
  spec.resumable = message.resumable();
  spec.lock_file = message.lock_file();
  spec.grace_s = message.grace_s();
  spec.shares = message.shares();
  for (const std::uint32_t node : message.nodes()) spec.table.nodes.push_back(NodeId{node});
  for (int t = 0; t < message.incarnations_size(); ++t)
    spec.table.incarnations.push_back({Term{message.incarnation_terms(t)}, message.incarnations(t)});
  spec.table.epoch = {Term{message.epoch_term()}, message.epoch()};
  spec.table.stage = message.stage();
  return spec;
}

}  // namespace tessera
