// What came of a process, told in the same way whether it was done here or by a daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "src/front/apps/command.h"
#include "src/result/export/export.h"
#include "src/result/verify/verify.h"

namespace tessera {

void print_verified(const std::string& result, const VerifyReport& report, const OutputOptions& output);
// `max_edge`: the length as it was given, if it was.
void print_exported(const Exported& exported, const std::optional<std::string>& max_edge, const OutputOptions& output);

// Of the objects that a daemon has. Nothing when they are none.
std::optional<VerifyReport> verified_of(const nlohmann::ordered_json& outcome);
std::optional<Exported> exported_of(const nlohmann::ordered_json& outcome);

}  // namespace tessera
