// The question neighbours: which vertices share an edge with a vertex. The answer as text for people, or as one line of
// JSON.
#pragma once

#include <string>

#include "src/result/query/stored_triangulation.h"

namespace tessera::query {

// `part` is true for a region; then the answer says whether it is final.
std::string text_of(const Neighbours& found, bool part = false);
std::string json_of(const Neighbours& found, bool part = false);

}  // namespace tessera::query
