// Cells of tiles that are kept as points, as files: byte for byte those of a job that stores cells.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

struct MaterialiseOptions {
  // Empty: the result itself is changed, by a new version of it (src/result/new_version.h). Else a new folder, a result
  // of its own, whole or not at all.
  std::filesystem::path to = {};
  std::optional<Box> box = {};     // only tiles whose box of the partition meets this closed box
  std::uint64_t memory_bytes = 0;  // at least what a tile takes is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // told the part that is done, by one thread at a time; or null
};

struct Materialised {
  std::filesystem::path folder;
  std::uint32_t version = 1;  // of the result there
  std::uint64_t tiles = 0;    // that have cells now, and had not
  std::uint64_t left_as_points = 0;
  std::uint64_t bytes = 0;  // of these tiles' files
};

// Errors: usage when the result has no tile that is kept as points, when the folder is there already, when another
// process works in it; corrupt for a tile that is not what was stored; io, memory, interrupted.
Result<Materialised> materialise(const std::filesystem::path& result, const MaterialiseOptions& options,
                                 std::stop_token stop);

}  // namespace tessera
