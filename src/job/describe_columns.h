// The columns of a result as JSON and as words.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "src/result/store/tile_store.h"

namespace tessera {

nlohmann::ordered_json columns_to_json(const Manifest& manifest);
// Returns one line, from what columns_to_json() returned: "volume of cells, star_volume of vertices".
std::string columns_in_words(const nlohmann::ordered_json& columns);

}  // namespace tessera
