// plan.json: a RoutedCloud as text.
#pragma once

#include <string>
#include <string_view>

#include "src/tiling/routed_cloud.h"

namespace tessera {

// Writes RUN/plan.json under a temporary name, synced and renamed: it is there as a whole or not at all. Returns its
// checksum, RoutedCloud::seal.
Result<std::uint64_t> write_plan(const RoutedCloud& run);
// `json`, an object, with the checksum of its text as first member, on a line of its own: so that a flipped digit
// shows.
std::string sealed_plan(std::string_view json);

}  // namespace tessera
