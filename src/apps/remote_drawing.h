// region, dem and contours, done by a daemon.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/apps/command.h"
#include "src/base/result.h"

namespace tessera {

// `out`: the name of the result there.
Status region_remotely(Settings& settings, const std::vector<std::string>& inputs, const std::string& out,
                       const OutputOptions& output);

// `process`: dem or contours. The file arrives at `target`, and stays at the daemon only with --detach.
Status draw_remotely(Settings& settings, const std::string& process, const std::string& result,
                     const std::filesystem::path& target, const OutputOptions& output);

// What a job of these processes found, for people; nothing when it is none of them.
std::optional<std::string> drawn_text(const nlohmann::ordered_json& outcome);

}  // namespace tessera
