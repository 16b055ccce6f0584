// Jobs and results of a daemon, as lines for people and objects for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "service.pb.h"

namespace tessera {

// accepted and running have not.
bool has_ended(const proto::StatusInfo& job);

// A table with a head, the last line end included; a sentence when there is nothing.
std::string jobs_text(const std::vector<proto::StatusInfo>& jobs);
std::string results_text(const std::vector<proto::TriangulationInfo>& results);
// All that is known of one, a line for each.
std::string job_text(const proto::StatusInfo& job);

// {"event":"job","id":...}, {"event":"result","name":...}.
nlohmann::ordered_json job_json(const proto::StatusInfo& job);
nlohmann::ordered_json result_json(const proto::TriangulationInfo& result);

}  // namespace tessera
