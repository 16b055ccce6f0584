// plan.json: a RoutedRun as text.
#pragma once

#include "src/tiling/routed_run.h"

namespace tessera {

// Writes RUN/plan.json under a temporary name, synced and renamed: it is there as a whole or not at all.
Status write_plan(const RoutedRun& run);

std::filesystem::path plan_file(const std::filesystem::path& run_folder);

}  // namespace tessera
