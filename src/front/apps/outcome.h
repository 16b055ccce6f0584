// Prints the outcome of verify and export. The text is the same for work of this process and of a daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "src/front/apps/command.h"
#include "src/front/apps/settings.h"
#include "src/result/export/export.h"
#include "src/result/verify/verify.h"

namespace tessera::apps {

void print_verified(const std::string& result, const VerifyReport& report, const OutputOptions& output);
// What the cells that an export leaves out have, with the lengths as the user typed them: "longer edges than 2"; empty
// if it leaves out none.
std::string limits_text(const Settings& settings);
// `limits`: what limits_text() returned.
void print_exported(const Exported& exported, const std::string& limits, const OutputOptions& output);

// These read the outcome in a daemon's JSON object; no value if the object is something else.
std::optional<VerifyReport> verified_of(const nlohmann::ordered_json& outcome);
std::optional<Exported> exported_of(const nlohmann::ordered_json& outcome);

}  // namespace tessera::apps
