// Prints the outcome of region, dem and contours. The text is the same for work of this process and of a daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "src/front/apps/command.h"
#include "src/job/region_job.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/dem.h"

namespace tessera::apps {

void print_drawn(const RegionSummary& region, const OutputOptions& output);
void print_drawn(const Dem& dem, const OutputOptions& output);
void print_drawn(const Contours& contours, const OutputOptions& output);

// Prints the outcome in a daemon's JSON object, also one of products.h. Returns false, and prints nothing, if it is of
// another process.
bool print_drawn(const nlohmann::ordered_json& outcome, const OutputOptions& output);

}  // namespace tessera::apps
