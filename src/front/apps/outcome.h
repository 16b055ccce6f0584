// Prints the outcome of verify, export, hag, measure and update. The text is the same for work of this process and of a
// daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/front/apps/command.h"
#include "src/front/apps/settings.h"
#include "src/result/export/export.h"
#include "src/result/heights/copies.h"
#include "src/result/measure/measure.h"
#include "src/result/verify/verify.h"

namespace tessera::apps {

void print_verified(const std::string& result, const VerifyReport& report, const OutputOptions& output);
// What the cells that an export leaves out have, with the lengths as the user typed them: "longer edges than 2"; empty
// if it leaves out none.
std::string limits_text(const Settings& settings);
// `limits`: what limits_text() returned.
void print_exported(const Exported& exported, const std::string& limits, const OutputOptions& output);
// `outside`: whether --outside was given; no value when that is not known.
void print_heights(const std::string& folder, const std::vector<HeightsFile>& files, std::optional<bool> outside,
                   const OutputOptions& output);
void print_measured(const Measured& measured, const OutputOptions& output);
// `told`: the members that print_updated() needs and that are missing are left out of the text.
void print_updated(const nlohmann::ordered_json& told, const OutputOptions& output);
bool is_updated(const nlohmann::ordered_json& outcome);

// These read the outcome in a daemon's JSON object; no value if the object is something else.
std::optional<VerifyReport> verified_of(const nlohmann::ordered_json& outcome);
std::optional<Exported> exported_of(const nlohmann::ordered_json& outcome);
std::optional<std::vector<HeightsFile>> heights_of(const nlohmann::ordered_json& outcome);
std::optional<Measured> measured_of(const nlohmann::ordered_json& outcome);

}  // namespace tessera::apps
