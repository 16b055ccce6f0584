// Jobs, results, inputs and nodes of a daemon, as lines for people and objects for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "service.pb.h"

namespace tessera {

// A node of a cluster on this machine, and its process.
struct LocalNodeState {
  proto::NodeInfo info;  // its name alone, when the coordinator does not know it
  int process = 0;       // 0: it does not run
  std::string log;
};

// accepted and running have not.
bool has_ended(const proto::StatusInfo& job);

// A table with a head, the last line end included; a sentence when there is nothing.
std::string jobs_text(const std::vector<proto::StatusInfo>& jobs);
std::string results_text(const std::vector<proto::TriangulationInfo>& results);
// `folder`: what was asked for.
std::string inputs_text(const std::vector<proto::InputInfo>& inputs, const std::string& folder);
std::string nodes_text(const std::vector<proto::NodeInfo>& nodes);
std::string local_nodes_text(const std::vector<LocalNodeState>& nodes);
// All that is known of one, a line for each.
std::string job_text(const proto::StatusInfo& job);

// {"event":"job","id":...}, {"event":"result","name":...}, {"event":"node","name":...}.
nlohmann::ordered_json job_json(const proto::StatusInfo& job);
nlohmann::ordered_json result_json(const proto::TriangulationInfo& result);
// {"event":"input","name":...}; without what the file's header does not tell.
nlohmann::ordered_json input_json(const proto::InputInfo& input);
nlohmann::ordered_json node_json(const proto::NodeInfo& node);
// The same, with "pid" (0: it does not run) and "log".
nlohmann::ordered_json local_node_json(const LocalNodeState& node);

}  // namespace tessera
