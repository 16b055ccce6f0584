// Jobs, results, inputs and nodes of a daemon, as text for people and as JSON for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "service.pb.h"

namespace tessera::apps {

// A node of a cluster on this machine, and its process.
struct LocalNodeState {
  proto::NodeInfo info;  // only the name, if the coordinator does not know the node
  int process = 0;       // 0: the node does not run
  std::string log;
};

// Returns whether the job has ended: it is neither accepted nor running.
bool has_ended(const proto::StatusInfo& job);

// These return a table with a head, or a sentence if the list is empty. The text ends with a line end.
std::string jobs_text(const std::vector<proto::StatusInfo>& jobs);
std::string results_text(const std::vector<proto::TriangulationInfo>& results);
// `folder`: the folder that the user asked for.
std::string inputs_text(const std::vector<proto::InputInfo>& inputs, const std::string& folder);
std::string nodes_text(const std::vector<proto::NodeInfo>& nodes);
std::string local_nodes_text(const std::vector<LocalNodeState>& nodes);
// Returns all that is known of a job, a line for each item.
std::string job_text(const proto::StatusInfo& job);

// These return {"event":"job","id":...}, {"event":"result","name":...}, {"event":"input","name":...} and
// {"event":"node","name":...}.
nlohmann::ordered_json job_json(const proto::StatusInfo& job);
nlohmann::ordered_json result_json(const proto::TriangulationInfo& result);
// Leaves out what the header of the file does not tell.
nlohmann::ordered_json input_json(const proto::InputInfo& input);
nlohmann::ordered_json node_json(const proto::NodeInfo& node);
// Returns node_json() of the node with "pid" (0: the node does not run) and "log".
nlohmann::ordered_json local_node_json(const LocalNodeState& node);

}  // namespace tessera::apps
