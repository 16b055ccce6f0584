// What came of region, dem and contours, told in the same way whether it was done here or by a daemon.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "src/front/apps/command.h"
#include "src/job/region_job.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/dem.h"

namespace tessera {

void print_drawn(const RegionSummary& region, const OutputOptions& output);
void print_drawn(const Dem& dem, const OutputOptions& output);
void print_drawn(const Contours& contours, const OutputOptions& output);

// Of the object that a daemon has. False when it is of none of them; nothing is printed then.
bool print_drawn(const nlohmann::ordered_json& outcome, const OutputOptions& output);

}  // namespace tessera
