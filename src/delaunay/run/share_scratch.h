// What the shares of all kinds of jobs have in common on disk.
#pragma once

#include <filesystem>
#include <functional>

#include "src/exchange/share.h"

namespace tessera {

// Makes a new folder for a share of a cluster's job, under a node's scratch folder. Errors: usage when the node has no
// scratch folder; io when almost no space is free.
Result<std::filesystem::path> new_share_folder(const std::filesystem::path& scratch);

// Whether every tile that is `here`, and has not finished the share's stage, can finish by itself from what it left
// when all was quiet. `run`: the run folder of the job.
Result<bool> is_settled(const std::filesystem::path& run, const Share& share, std::uint32_t tiles,
                        const std::function<bool(TileId)>& here);

}  // namespace tessera
