// Writes the duplicates of a result, with pairs that may not fit into memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::store {

struct WrittenPairs {
  std::uint64_t count = 0;
  std::uint64_t xxh3 = 0;  // XXH3-64 of the file; 0 when there is none
};
// Writes the pairs in ascending order. Without pairs, removes the file of an earlier result. `pairs` cannot be used
// afterwards.
Result<WrittenPairs> write_duplicates(const std::filesystem::path& out, DuplicateSort& pairs);
// Writes the pairs, in ascending order, to a new file of any name.
Result<WrittenPairs> write_pairs(const std::filesystem::path& file, const std::filesystem::path& final_name,
                                 std::span<const DuplicatePair> pairs);

}  // namespace tessera::store
