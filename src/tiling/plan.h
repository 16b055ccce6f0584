// plan.json: a RoutedCloud as text.
#pragma once

#include <string>
#include <string_view>

#include "src/tiling/routed_cloud.h"

namespace tessera {

// Writes RUN/plan.json. The file is written under a temporary name, synced and renamed, so it is there as a whole or
// not at all. Returns its checksum, which is RoutedCloud::seal. Error io.
Result<std::uint64_t> write_plan(const RoutedCloud& run);
// Returns `json`, an object, with the checksum of its text as the first member, on a line of its own. So a flipped
// digit is noticed.
std::string sealed_plan(std::string_view json);

}  // namespace tessera
