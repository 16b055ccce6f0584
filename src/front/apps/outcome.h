// Prints the outcome of verify and export. The text is the same for work of this process and of a daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "src/front/apps/command.h"
#include "src/result/export/export.h"
#include "src/result/verify/verify.h"

namespace tessera::apps {

void print_verified(const std::string& result, const VerifyReport& report, const OutputOptions& output);
// `max_edge`: the length as the user typed it, if given.
void print_exported(const Exported& exported, const std::optional<std::string>& max_edge, const OutputOptions& output);

// These read the outcome in a daemon's JSON object; no value if the object is something else.
std::optional<VerifyReport> verified_of(const nlohmann::ordered_json& outcome);
std::optional<Exported> exported_of(const nlohmann::ordered_json& outcome);

}  // namespace tessera::apps
