// Reads members of a daemon's outcome, which is a JSON object.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera::apps {

inline std::uint64_t number(const nlohmann::ordered_json& outcome, const char* key) {
  return outcome.at(key).get<std::uint64_t>();
}
inline std::string text(const nlohmann::ordered_json& outcome, const char* key) {
  return outcome.at(key).get<std::string>();
}

}  // namespace tessera::apps
