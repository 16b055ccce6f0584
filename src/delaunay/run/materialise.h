// Writes the files of cells of tiles that are kept as points, byte for byte those of a job that stores cells.
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
  // Empty: the result itself is changed, by a new version of it (src/result/new_version.h). Else: a new folder, which
  // becomes a result of its own, as a whole or not at all.
  std::filesystem::path to = {};
  std::optional<Box> box = {};     // only tiles whose box of the partition meets this closed box
  std::uint64_t memory_bytes = 0;  // if it is less than one tile takes, that much is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // called with the fraction that is done, by one thread at a time; or null
  // For the log of versions.
  std::vector<std::string> command = {};
  std::string software_version = {};
};

struct Materialised {
  std::filesystem::path folder;
  std::uint32_t version = 1;  // of the result in `folder`
  std::uint64_t tiles = 0;    // tiles that have cells now, and had none before
  std::uint64_t left_as_points = 0;
  std::uint64_t bytes = 0;  // size of these tiles' files
};

// Makes the files of cells of the chosen tiles. Errors: usage when the result has no tile that is kept as points, when
// the folder is there already, or when another process works in it; corrupt when a tile is not what was stored; io,
// memory, interrupted.
Result<Materialised> materialise(const std::filesystem::path& result, const MaterialiseOptions& options,
                                 std::stop_token stop);

}  // namespace tessera
