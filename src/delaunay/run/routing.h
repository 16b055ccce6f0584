// What the nodes of a cluster must know to route input splits of a cloud, as one file of the run folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/tiling/split_router.h"

namespace tessera {

// Writes that file. Error io.
Status write_routing(const std::filesystem::path& run_folder, const Cloud& cloud, const std::vector<InputSplit>& splits,
                     const Partition& partition);

// Routes one of these input splits with `threads` threads. Errors of route_split() in split_router.h; corrupt.
Status route_split(const std::filesystem::path& run_folder, std::size_t split, std::uint32_t threads,
                   const SplitWork& work, const std::stop_token& stop);

}  // namespace tessera
