// What parts of all kinds of jobs have in common on disk.
#pragma once

#include <filesystem>
#include <functional>

#include "src/exchange/share.h"

namespace tessera {

// A new folder for a part of a cluster's job, under a node's scratch folder. Errors: usage when the node has none; io
// when it has next to no room.
Result<std::filesystem::path> new_part_folder(const std::filesystem::path& scratch);

// Whether each tile here that has not come to the end of the part's stage can do so by itself, from what it left when
// all was quiet. `run`: of the job.
Result<bool> is_settled(const std::filesystem::path& run, const Share& part, std::uint32_t tiles,
                        const std::function<bool(TileId)>& here);

}  // namespace tessera
