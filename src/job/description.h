// How a description is written: as one object, or as text for people made from it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

// With a line end. `counters`: of a result also what only whoever works on Tessera wants to know. REQUIRES: `described`
// is one of those of describe().
std::string written(const nlohmann::ordered_json& described, bool json, bool counters = false);

}  // namespace tessera
