// Checked reading of JSON that comes from a file. The functions return false where nlohmann's own would convert the
// value.
#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "src/base/point.h"

namespace tessera {

// Reads an integer in [least, most].
inline bool read_integer(const nlohmann::json& from, std::int64_t least, std::int64_t most, std::int64_t& value) {
  if (!from.is_number_integer()) return false;
  if (from.is_number_unsigned() && from.get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX)) return false;
  value = from.get<std::int64_t>();
  return least <= value && value <= most;
}

inline bool read_unsigned(const nlohmann::json& from, std::uint64_t& value) {
  if (!from.is_number_unsigned()) return false;
  value = from.get<std::uint64_t>();
  return true;
}

inline bool read_finite(const nlohmann::json& from, double& value) {
  if (!from.is_number()) return false;
  value = from.get<double>();
  return std::isfinite(value);
}

inline bool read_string(const nlohmann::json& from, std::string& value) {
  if (!from.is_string()) return false;
  value = from.get<std::string>();
  return true;
}

inline bool read_point(const nlohmann::json& from, Point& p) {
  return from.is_array() && from.size() == 3 && read_finite(from[0], p.x) && read_finite(from[1], p.y) &&
         read_finite(from[2], p.z);
}

}  // namespace tessera
