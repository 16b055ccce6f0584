// Prints the outcome of alpha, density, volume and voronoi. The text is the same for work of this process and of a
// daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "src/front/apps/command.h"
#include "src/result/alpha/alpha_shape.h"
#include "src/result/density/density.h"
#include "src/result/volume/volumes.h"
#include "src/result/voronoi/voronoi.h"

namespace tessera::apps {

// `general`: whether singular faces were asked for.
void print_product(const AlphaShape& shape, const OutputOptions& output);
void print_product(const density::GridFile& file, const OutputOptions& output);
void print_product(const WrittenVoronoi& written, const OutputOptions& output);
// How many rows the table has, and what was left out. Not the rows.
void print_product(const std::string& table, const Volumes& volumes, const OutputOptions& output);

// Prints the outcome in a daemon's JSON object. Returns false, and prints nothing, if it is of none of the four.
// Throws nlohmann::json::exception if the object has other members than expected.
bool print_product(const nlohmann::ordered_json& outcome, const OutputOptions& output);

}  // namespace tessera::apps
