// Writes a description as one object, or as text for people that is made from the object.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

// Returns the description, with a line end. `counters`: the text of a result also has figures that only developers of
// Tessera need. REQUIRES: `described` comes from describe().
std::string written(const nlohmann::ordered_json& described, bool json, bool counters = false);

}  // namespace tessera
