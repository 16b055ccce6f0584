// The units that inputs and results state.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "src/base/attribute.h"

namespace tessera {

// An object of units by the names of attributes, and of "coordinates"; without those that are unknown.
inline nlohmann::ordered_json units_of(const std::string& of_coordinates, const std::vector<Attribute>& attributes) {
  auto units = nlohmann::ordered_json::object();
  if (!of_coordinates.empty()) units["coordinates"] = of_coordinates;
  for (const Attribute& attribute : attributes)
    if (!attribute.unit.empty()) units[attribute.name] = attribute.unit;
  return units;
}

}  // namespace tessera
