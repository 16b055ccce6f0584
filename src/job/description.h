// How a description is written: as one object, or as text for people made from it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

// With a line end. REQUIRES: `described` is one of those of describe().
std::string written(const nlohmann::ordered_json& described, bool json);

}  // namespace tessera
